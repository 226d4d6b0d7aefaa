#pragma once

#include "shared/dynamics/prescribed_motion.hpp"

namespace stillgrid::bodies {

enum class Motion { kFree, kStatic, kPrescribed };

/// In a body's description it begins at zero, in the world at the body's place.
using dynamics::PrescribedMotion;

}  // namespace stillgrid::bodies
