#pragma once

#include <stdexcept>

namespace stillgrid::laboratory {

/// The machine is at fault, not what the user gave: no room for a file, no temporary folder. The
/// same again may do. One line.
class CannotStart : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace stillgrid::laboratory
