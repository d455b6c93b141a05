// Gathers the results of all experiments in a folder into <folder>/index.html.

#include <cstdio>
#include <exception>
#include <string>

#include "experiments/support/files.h"
#include "experiments/support/page.h"

int main(int argc, char** argv) {
  const std::string folder = argc == 2 ? argv[1] : "";
  if (folder.empty() || folder.starts_with('-')) {
    std::fputs("usage: page FOLDER   writes FOLDER/index.html from FOLDER/*/manifest.json\n",
               folder == "--help" ? stdout : stderr);
    return folder == "--help" ? 0 : 2;
  }
  try {
    const int shown = feder::experiments::write_page(folder);
    std::printf("%s/index.html shows %d experiment%s\n", folder.c_str(), shown, shown == 1 ? "" : "s");
    return 0;
  } catch (const feder::experiments::IoError& error) {
    std::fprintf(stderr, "page: io_error: %s\n", error.what());
    return 4;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "page: internal_error: %s\n", error.what());
    return 1;
  }
}
