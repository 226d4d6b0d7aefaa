#pragma once

namespace stillgrid::realtime {

/// Exit status of every program: docs/formats.md, "Programs".
enum ExitStatus : int {
  kDone = 0,
  kBadInput = 1,  // one line on standard error names file, key and value
  kCouldNotStart =
      2,  // permissions, version mismatch, no segment in time, a lockstep peer that died
  kDeviceFault = 3,
  kRealtimeViolation = 4,  // a test mode's: docs/realtime.md
  kToleranceNotReached =
      4,              // sphere_decompose: files are written, farther from the mesh than asked
  kNotConverged = 5,  // do not trust the simulation. Its state is not finite, it gained energy, or
                      // most steps did not converge (in real time: all).
  kIncomplete = 6,    // ticks are missing from a recording
  kSignalled = 128,   // and the signal's number: ended by it, as shells have it
};

}  // namespace stillgrid::realtime
