#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>
#include <system_error>

#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::command_line {

/// Returns the status, or prints a line and returns kCouldNotStart if standard output took less
/// than was printed.
inline int after_output(const CLI::App& app, int status) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  std::fprintf(stderr, "%s: standard output could not be written to its end\n",
               app.get_name().c_str());
  return realtime::kCouldNotStart;
}

/// Parses a program's options and does its work: the exit status that main() returns. --help and
/// --version are printed; StopRequested is a line and done; any other exception is one line on
/// standard error that names the program, and bad input.
template <class Work>
int run_program(CLI::App& app, int argc, char** argv, const Work& work) {
  try {
    app.parse(argc, argv);
    return after_output(app, work());
  } catch (const CLI::Success& printed) {
    return after_output(app, app.exit(printed));
  } catch (const CLI::RuntimeError& said) {
    return said.get_exit_code();  // of an option that is the whole of its work
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: out of memory\n", app.get_name().c_str());
    return realtime::kCouldNotStart;
  } catch (const realtime::StopRequested& stop) {
    std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), stop.what());
    return realtime::kDone;
  } catch (const std::system_error& error) {
    // The library's own line for a thread that the system refuses has no subject.
    const bool is_thread = error.code() == std::errc::resource_unavailable_try_again;
    std::fprintf(stderr, "%s: %s%s\n", app.get_name().c_str(),
                 is_thread ? "cannot make a thread (ulimit -u): " : "", error.what());
    return realtime::kBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), error.what());
    return realtime::kBadInput;
  }
}

}  // namespace stillgrid::command_line
