// Writes the sample scene's files into the folder given, for readers of other makers.
#include "tests/experiments/frame_sample.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  feder::experiments::create_folder(argv[1]);
  feder::experiments::write_sample(feder::experiments::sample_scene(), 5, argv[1]);
}
