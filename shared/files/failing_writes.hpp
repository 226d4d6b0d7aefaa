#pragma once

namespace stillgrid::files {

/// From now on a write beyond a limit of size, or into a pipe that nobody reads, fails with an
/// error, as one to a full disk does, and does not end the process: no loop may stop for a file.
/// Once per process, before threads.
void make_writes_fail();

}  // namespace stillgrid::files
