// Stands for `simulate` where the sweep itself is tested: its command line, its manifest, and every way to
// fail.
// `--set do=WORD` chooses the ending. Each start leaves a line in the file named by FAKE_SIMULATE_LOG.

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

namespace {

struct Arguments {
  std::string scene, out;
  std::map<std::string, std::string> set;
  bool reference = false;
};

Arguments read_arguments(int argc, char** argv) {
  Arguments arguments;
  arguments.scene = argv[1];
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--reference") arguments.reference = true;
    if (word == "--out") arguments.out = argv[++i];
    if (word != "--set") continue;
    const std::string change = argv[++i];
    const std::size_t equals = change.find('=');
    arguments.set[change.substr(0, equals)] = change.substr(equals + 1);
  }
  return arguments;
}

void note_start(const Arguments& arguments) {
  const char* path = std::getenv("FAKE_SIMULATE_LOG");
  if (path == nullptr) return;
  std::ofstream(path, std::ios::app) << std::filesystem::path(arguments.out).filename().string() + "\n";
}

void write_manifest(const Arguments& arguments, const std::string& status, const std::string& reason) {
  const auto given = arguments.set.find("method.dt");
  const double dt = given == arguments.set.end() ? 0.5 : std::strtod(given->second.c_str(), nullptr);
  std::FILE* file = std::fopen((arguments.out + "/manifest.tmp").c_str(), "w");
  std::fprintf(
      file,
      "{\"program\": \"simulate\", \"status\": \"%s\", \"reason\": \"%s\", \"results\": {"
      "\"scene\": \"%s\", \"integrator\": \"fake\", \"dt\": %.17g, \"steps\": %d, \"error\": %.17g, "
      "\"reference_error\": %s, \"energy_drift\": null, \"seconds\": %d.5}, \"results_hash\": \"0\"}\n",
      status.c_str(), reason.c_str(), std::filesystem::path(arguments.scene).stem().c_str(), dt,
      static_cast<int>(1 / dt), dt * dt / 3, arguments.reference ? "1e-12" : "null", ::getpid());
  std::fclose(file);
  std::filesystem::rename(arguments.out + "/manifest.tmp", arguments.out + "/manifest.json");
}

int fail(int code, const char* text) {
  std::fputs(text, stderr);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  // A broken sweep must not leave this behind for ever.
  ::alarm(60);
  const Arguments arguments = read_arguments(argc, argv);
  std::filesystem::create_directories(arguments.out);
  note_start(arguments);
  const auto delay = arguments.set.find("milliseconds");
  if (delay != arguments.set.end()) ::usleep(1000 * static_cast<unsigned>(std::stoi(delay->second)));
  const auto chosen = arguments.set.find("do");
  const std::string what = chosen == arguments.set.end() ? "ok" : chosen->second;
  if (what == "crash") ::raise(SIGSEGV);
  if (what == "deaf") ::signal(SIGTERM, SIG_IGN);
  while (what == "hang" || what == "deaf") ::pause();
  if (what == "nothing") return 0;
  if (what == "nothing3") return 3;
  if (what == "input") return fail(2, "simulate: bad_input: the rope has no mass\nsee line 7\n");
  if (what == "memory") return fail(5, "simulate: out_of_memory: out of memory\n");
  if (what == "preempted") return fail(130, "simulate: interrupted: stopped\n");
  if (what == "disk") return fail(4, "simulate: io_error: no space\n");
  if (what == "garbage") std::ofstream(arguments.out + "/manifest.json") << "{\"status\": ";
  if (what == "garbage") return 0;
  if (what == "diverged") return write_manifest(arguments, "diverged", "energy, 1e9 J at t = 0.1 s"), 3;
  if (what == "liar") return write_manifest(arguments, "ok", ""), 3;
  write_manifest(arguments, "ok", "");
  return 0;
}
