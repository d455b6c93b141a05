// Bad input is refused before anything is built, with the place, the value and what was expected.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/check.h"
#include "models/catalog.h"
#include "models/chain.h"

namespace feder {
namespace {

std::string message(const std::string& spec) {
  try {
    make_model(spec);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

struct Case {
  const char* spec;
  std::vector<const char*> parts;
};

TEST(SpecErrors, NameThePlaceTheValueAndTheExpectation) {
  const std::vector<Case> cases = {
      {"", {"model ''", "unknown", "Models: oscillator"}},
      {"chian", {"'chian'", "did you mean 'chain'?", "lattice", "S1(n)"}},
      {"S3(10)", {"'S3(10)'", "did you mean 'S1'?"}},
      {"S1", {"'S1'", "expected S1(n)"}},
      {"S1(10", {"'S1(10'", "expected S1(n)"}},
      {"S1()", {"model hanging_chain", "n = ''", "an integer >= 1"}},
      {"S1(1,2)", {"'S1(1,2)'", "expected S1(n), for example S1(10)"}},
      {"S3b", {"'S3b'", "expected S3b(nx,ny), for example S3b(10,10)"}},
      {"S3b(30)", {"'S3b(30)'", "expected S3b(nx,ny)"}},
      {"S3b(1,2,3)", {"'S3b(1,2,3)'", "expected S3b(nx,ny)"}},
      {"S3b(30,)", {"model plate_bridge", "ny = ''", "an integer >= 1"}},
      {"S3b(1,10)", {"model plate_bridge", "nx = 1", ">= 2"}},
      {"S4(1)", {"model lattice", "n = 1", ">= 2"}},
      {"S4(abc)", {"model lattice", "n = 'abc'"}},
      {"chain(10)", {"'chain(10)'", "unknown"}},
      {"chain:", {"model chain", "setting ''", "key=value"}},
      {"chain:n", {"model chain", "'n'", "key=value"}},
      {"chain:stifness=1", {"model chain", "'stifness'", "did you mean 'stiffness'?", "rest_length"}},
      {"chain:n=5,n=6", {"model chain", "'n'", "twice"}},
      {"chain:n=0", {"model chain", "n = 0", "an integer >= 1"}},
      {"chain:n=2.5", {"n = '2.5'", "an integer"}},
      {"chain:n=1e99", {"n = '1e99'", "an integer"}},
      {"chain:n=20000000", {"n = 20000000", "<= 1e+07"}},
      {"chain:mass=-1", {"mass = -1 kg", "a finite number > 0"}},
      {"chain:mass=nan", {"mass = nan kg", "a finite number > 0"}},
      {"chain:mass=1kg", {"mass = '1kg'", "a finite number > 0"}},
      {"chain:mass=1e999", {"mass = '1e999'", "a finite number > 0"}},
      {"chain:mass=", {"mass = ''", "a finite number > 0"}},
      {"chain:stiffness=rigid", {"stiffness = inf N/m", "a finite number > 0"}},
      {"chain:drag=-1e-3", {"drag = -0.001", "kg/s", ">= 0"}},
      {"chain:damping_time=inf", {"damping_time = inf s", ">= 0"}},
      {"chain:modes=11:1e-3", {"model chain", "mode number = 11", "1 to 10"}},
      {"chain:modes=0:1e-3", {"mode number = 0", "1 to 10"}},
      {"chain:modes=1:1e-3/", {"modes = ''", "mode:amplitude"}},
      {"chain:modes=1", {"modes = '1'", "mode:amplitude"}},
      {"chain:modes=1:nan", {"modes = nan m", "a finite number"}},
      {"chain:modes=1:1", {"model chain", "shortening", "less than the rest length 0.1"}},
      {"oscillator:mass=1e-300,stiffness=1e300", {"model oscillator", "end time = 0 s", "> 0"}},
      {"oscillator:amplitude=2", {"amplitude = 2 m", "less than the rest length 1"}},
      {"damped_oscillator:velocity=100", {"largest elongation", "less than the rest length"}},
      {"pendulum:angle=3.15", {"angle = 3.1", "rad", "> 0 and < 3.14"}},
      {"pendulum:angle=0", {"angle = 0 rad"}},
      {"spring_pendulum:elongation=-1", {"elongation = -1 m", "more than -length"}},
      {"taut_string:tension=1e4", {"tension = 10000 N", "less than stiffness times link length"}},
      {"bending_rod:amplitude=0.2", {"amplitude = 0.2", "m, expected less than length / 10"}},
      {"bending_rod:support=free", {"support = 'free'", "one of cantilever, pinned"}},
      {"bending_rod:support=pinned,axial_stiffness=inf", {"axial_stiffness = inf N", "cannot bend"}},
      {"cloth:n=5000", {"model cloth", "nodes n^2 = 25000000", "at most 1e+07"}},
      {"cloth:n=3000", {"model cloth", "springs = 5397", "at most 3e+07"}},
      {"plate_bridge:nx=100000,ny=1000", {"model plate_bridge", "nodes", "at most 1e+07"}},
      {"plate_net:n=9999", {"model plate_net", "nodes", "at most 1e+07"}},
      {"plate_net:stiffness=0", {"stiffness = 0 N/m"}},
      {"lattice:n=9999999", {"model lattice", "nodes n^3", "at most 1e+07"}},
      {"lattice:stiffness=rigid", {"stiffness = inf N/m", "a finite number > 0"}},
  };
  for (const Case& c : cases) {
    const std::string text = message(c.spec);
    for (const char* part : c.parts)
      EXPECT_NE(text.find(part), std::string::npos)
          << "'" << c.spec << "' gave: " << text << "\nwithout: " << part;
  }
}

TEST(SpecErrors, QuoteHostileTextShortAndPrintable) {
  const std::string text = message(std::string(100000, '\x1b'));
  EXPECT_LT(text.size(), 600u);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_LT(message("chain:" + std::string(100000, 'x') + "=1").size(), 600u);
}

TEST(SpecErrors, CatchOptionStructsToo) {
  Chain o;
  o.n = -1;
  EXPECT_THROW(make_chain(o), InputError);
  EXPECT_EQ(message("chain:n=3"), "accepted");
}

}  // namespace
}  // namespace feder
