#pragma once

#include <string>

namespace stillgrid::scene_relay {

/// Lets every UDP socket of this process receive from that interface and the loopback alone. The
/// middleware binds to all addresses of a machine, whichever interface it is told to send from:
/// what comes by another would be heard too. Needs no right. Throws NetworkError where the kernel
/// refuses.
void hear_only(const std::string& interface);

}  // namespace stillgrid::scene_relay
