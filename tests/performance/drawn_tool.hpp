#pragma once

namespace stillgrid::performance {

/// Prints a row for each place of a tool that is drawn over a flat face of a box, turned off the
/// axes, at an even depth: model,size_mm,along_mm,normal,sideways; forces over the exact one.
void print_drawn_tool();

/// Prints a row for each depth and model of a rod of spheres, pressed slanting into a corner of two
/// walls that are one mesh, or two: walls,model,size_mm,depth_mm, then along the rod's own axes
/// force and torque about its middle for 1 N/m, and the exact ones.
void print_rod_in_corner();

}  // namespace stillgrid::performance
