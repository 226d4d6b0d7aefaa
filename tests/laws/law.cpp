#include "tests/laws/law.hpp"

#include <array>

namespace stillgrid::laws {
namespace {

// Seeds of the common tests: some 15 s in all. Cases an hour: of one processor of 2 to 3 GHz.
constexpr std::array<Law, 18> kLaws = {{
    {1, "finite",
     "No state, force or torque is infinite or no number; |force| is within what the deepest "
     "possible overlap allows",
     finite_and_bounded, 20, 60'000},
    {2, "no step of its own",
     "Between two ticks the force changes by no more than the world makes it", no_step_of_its_own,
     20, 30'000},
    {3, "interface makes no energy",
     "What the hand gets and what the simulation books add up: the interface makes nothing in any "
     "second",
     interface_makes_nothing, 10, 20'000},
    {4, "passive limits",
     "A safety stage gives the hand no energy that the unlimited force would not give",
     limits_are_passive, 20, 60'000},
    {5, "purity", "Accounting and publishing change no byte of the motion", looking_changes_nothing,
     10, 20'000},
    {6, "order and frames",
     "Another order, place, attitude, mirror or moving frame gives the same motion to rounding",
     order_and_frame_change_nothing, 10, 30'000},
    {7, "units", "Masses and stiffnesses times 10 give the same motion, and 10 times the force",
     units_change_nothing, 10, 15'000},
    {8, "refinement", "Halving the step leaves of the error what the method's order says",
     refinement_converges, 5, 10'000},
    {9, "rest",
     "With damping and without a hand energy falls to its floor, accounts stand still, all sleeps",
     comes_to_rest, 5, 5'000},
    {10, "standing",
     "What is stable by its ideal stiffness stands; below the friction angle nothing creeps",
     stands, 2, 600},
    {11, "no tunnel", "What would cross within a step meets, or is counted", nothing_tunnels, 10,
     20'000},
    {12, "deadline", "A step with a deadline ends by it plus 10 %", keeps_its_deadline, 2, 3'000},
    {13, "linear cost", "Memory and load time grow linearly with the scene", costs_are_linear, 2,
     2'000},
    {14, "verdicts", "A stability limit is the worst of 8 seeds of 20 s", verdict_is_the_worst, 0,
     100},
    {15, "every vector", "The same motion on every instruction set that the processor has",
     every_vector_alike, 10, 20'000},
    {16, "no gain", "What tumbles or drops, undriven, never has more energy than it had",
     nothing_gains_energy, 16, 20'000},
    {17, "one simulation",
     "With `local` the force is equal to the bit, however slow, late and uneven the simulation is",
     one_simulation, 20, 10'000},
    {18, "solid", "A tool feels surfaces, not covers: it stays outside, sticks, and gains nothing",
     feels_solid, 18, 4'000},
}};

}  // namespace

std::span<const Law> all_laws() {
  return kLaws;
}

const Law& law_of(int number) {
  return kLaws.at(static_cast<std::size_t>(number - 1));
}

}  // namespace stillgrid::laws
