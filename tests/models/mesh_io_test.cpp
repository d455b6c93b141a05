// Files as they should be and as they should not be; tinyobjloader judges what an OBJ file says.
#include "models/mesh_io.h"

#include <gtest/gtest.h>
#include <tiny_obj_loader.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <sstream>

#include "engine/check.h"
#include "engine/mass_properties.h"
#include "tests/experiments/temporary_folder.h"
#include "tests/support/random.h"

namespace feder {
namespace {

const Vector3d kEdges(1.5, 0.25, 0.625), kCentre(0.5, -2.0, 4.25);  // exact as float too

Vector3d corner(int i) {
  return kCentre + 0.5 * Vector3d((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1)
                             .cwiseProduct(kEdges);
}
// counter-clockwise seen from outside
constexpr int kSides[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                              {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

std::string box_obj() {
  std::ostringstream out;
  out << "# a box\nmtllib none.mtl\no box\n";
  for (int i = 0; i < 8; ++i)
    out << "v " << corner(i)[0] << ' ' << corner(i)[1] << "\t" << corner(i)[2] << "\r\n";
  out << "vt 0 0\nvn 1 0 0\ng sides\nusemtl red\ns off\n";
  for (const auto& side : kSides) {
    out << 'f';
    for (const int i : side)
      out << ' ' << i + 1 << (&side == &kSides[0] ? "/1/1" : &side == &kSides[1] ? "//1" : "");
    out << "  # a side\n";
  }
  return out.str();
}

std::vector<Vector3d> box_triangles() {
  std::vector<Vector3d> out;
  for (const auto& s : kSides)
    for (const int i : {s[0], s[1], s[2], s[0], s[2], s[3]}) out.push_back(corner(i));
  return out;
}

std::string box_ascii_stl() {
  std::ostringstream out;
  out << "solid a box with a name\n";
  const auto points = box_triangles();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i % 3 == 0) out << "facet normal 0 0 nan\n outer loop\n";
    out << "  vertex " << points[i].transpose() << "\n";
    if (i % 3 == 2) out << " endloop\nendfacet\n";
  }
  out << "endsolid a box with a name\n";
  return out.str();
}

void append(std::string& out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i) & 255u);
}

std::string binary_stl(const std::vector<Vector3d>& points, const std::string& title = "solid but binary") {
  std::string out = title;
  out.resize(80, ' ');
  append(out, static_cast<std::uint32_t>(points.size() / 3));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i % 3 == 0) out.append(12, '\0');
    for (int axis = 0; axis < 3; ++axis)
      append(out, std::bit_cast<std::uint32_t>(static_cast<float>(points[i][axis])));
    if (i % 3 == 2) out.append(2, '\0');
  }
  return out;
}

class MeshIo : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_.path() / name, std::ios::binary) << content;
    return folder_.path() / name;
  }
  std::string message(const std::string& name, const std::string& content) const {
    const std::filesystem::path path = write(name, content);
    try {
      static_cast<void>(read_mesh(path));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
  experiments::TemporaryFolder folder_;
};

TEST_F(MeshIo, ABoxHasItsMassPropertiesInEveryFormat) {
  constexpr double kDensity = 700.0;
  const double mass = kDensity * kEdges.prod();
  const MassProperties box = solid_box("box", mass, kEdges);
  for (const auto& [name, content] :
       {std::pair("box.obj", box_obj()), std::pair("ascii.stl", box_ascii_stl()),
        std::pair("binary.STL", binary_stl(box_triangles()))}) {
    const TriangleMesh mesh = read_mesh(write(name, content));
    EXPECT_EQ(mesh.vertices.size(), 8u) << name;
    EXPECT_EQ(mesh.triangles.size(), 12u) << name;
    const MassProperties own = solid_mesh(name, kDensity, mesh);
    EXPECT_NEAR(own.mass, mass, 1e-14 * mass) << name;
    EXPECT_LT((own.centre - kCentre).norm(), 1e-14 * kCentre.norm()) << name;
    EXPECT_LT((own.inertia - box.inertia).norm(), 1e-14 * box.inertia.norm()) << name;
  }
}

TEST_F(MeshIo, NumbersAreReadToTheBit) {
  Random random(3);
  std::string text;
  std::vector<double> numbers;
  for (int i = 0; i < 3000; ++i) {
    numbers.push_back(random.uniform() * std::pow(10.0, random.below(20) - 10));
    char digits[40];
    std::snprintf(digits, sizeof digits, "%s%.17g", i % 3 == 0 ? "v " : " ", numbers.back());
    text += std::string(digits) + (i % 3 == 2 ? "\n" : "");
  }
  const TriangleMesh mesh = read_obj("text", text + "f 1 2 3\n");
  ASSERT_EQ(mesh.vertices.size(), 1000u);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    EXPECT_EQ(mesh.vertices[i / 3][static_cast<int>(i % 3)], numbers[i]);
}

TEST_F(MeshIo, TinyobjloaderReadsTheSameTriangles) {
  Random random(5);
  std::ostringstream text;
  const int vertices = 200;
  for (int i = 0; i < vertices; ++i) {
    if (i == 100) text << "f 1 2 3\nf -1 -2 -100\n";
    text << "v " << random.below(1000) << ' ' << 0.125 * random.below(99) << ' ' << -random.below(7) << "\n";
  }
  text << "vt 0 0\nvn 0 0 1\n";
  for (int i = 0; i < 300; ++i) {
    text << (i % 50 == 0 ? "g part\nf" : "f");
    for (int k = 0; k < 3; ++k)
      text << ' ' << (i % 3 == 0 ? -1 - random.below(vertices) : 1 + random.below(vertices))
           << (i % 4 == 0   ? "/1"
               : i % 4 == 1 ? "//1"
               : i % 4 == 2 ? "/1/1"
                            : "");
    text << "\n";
  }
  const TriangleMesh mesh = read_obj("text", text.str());
  std::istringstream in(text.str());
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  ASSERT_TRUE(tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &in, nullptr, true, false))
      << error;
  ASSERT_EQ(mesh.vertices.size() * 3, attributes.vertices.size());
  for (std::size_t i = 0; i < attributes.vertices.size(); ++i)
    EXPECT_NEAR(mesh.vertices[i / 3][static_cast<int>(i % 3)], attributes.vertices[i],
                1e-15 * std::abs(attributes.vertices[i]));
  std::vector<int> judged, own;
  for (const auto& shape : shapes)
    for (const auto& index : shape.mesh.indices) judged.push_back(index.vertex_index);
  for (const auto& triangle : mesh.triangles) own.insert(own.end(), triangle.begin(), triangle.end());
  EXPECT_EQ(own, judged);
  EXPECT_EQ(own.size(), 906u);
}

/// Area and, for the sum of the triangles' own areas, whether they overlap.
std::pair<Vector3d, double> areas(const TriangleMesh& mesh) {
  std::pair<Vector3d, double> out{Vector3d::Zero(), 0.0};
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto at = [&](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
    const Vector3d n = 0.5 * (at(b) - at(a)).cross(at(c) - at(a));
    out.first += n;
    out.second += n.norm();
  }
  return out;
}

TEST_F(MeshIo, PolygonsAreCutWithoutOverlapWhereverTheyLie) {
  const std::vector<std::vector<Vector3d>> shapes = {
      {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}},  // a U
      {{0, 0, 0}, {2, 2, 0}, {0, 1, 0}, {-2, 2, 0}},                                             // a dart
      {{0, 0, 0},
       {1, 0, 0},
       {2, 0, 0},
       {3, 0, 0},
       {3, 1, 0},
       {1.5, 1, 0},
       {1.5, 2, 0},
       {0, 2, 0},
       {0, 1, 0}}};  // collinear
  const double exact[] = {7.0, 2.0, 4.5};
  Random random(6);
  for (std::size_t k = 0; k < shapes.size(); ++k)
    for (int i = 0; i < 100; ++i) {
      const Eigen::AngleAxisd turn(random.uniform(0.0, 3.0), random.vector().normalized());
      const Vector3d shift = random.vector(20.0);
      const bool turned = i > 0;
      std::ostringstream text;
      text.precision(17);
      const std::size_t n = shapes[k].size();
      for (std::size_t j = 0; j < n; ++j) {
        const Vector3d& x = shapes[k][(j + static_cast<std::size_t>(i)) % n];
        text << "v " << (turned ? Vector3d(turn * x + shift) : x).transpose() << "\n";
      }
      text << "f";
      for (std::size_t j = 1; j <= n; ++j) text << ' ' << j;
      const TriangleMesh mesh = read_obj("polygon", text.str() + "\n");
      EXPECT_EQ(mesh.triangles.size(), n - 2);
      const auto [vector, sum] = areas(mesh);
      EXPECT_NEAR(vector.norm(), exact[k], 1e-12);
      EXPECT_NEAR(sum, exact[k], 1e-12) << "shape " << k << " turn " << i;
    }
}

TEST_F(MeshIo, ARingOfAThousandCornersIsCut) {
  std::ostringstream text;
  text.precision(17);
  for (int i = 0; i < 1000; ++i) {  // a star, concave at every other corner
    const double radius = i % 2 == 0 ? 2.0 : 1.0, angle = 2.0 * std::numbers::pi * i / 1000;
    text << "v " << radius * std::cos(angle) << ' ' << radius * std::sin(angle) << " 0\n";
  }
  text << "f";
  for (int i = 1; i <= 1000; ++i) text << ' ' << i;
  const TriangleMesh mesh = read_obj("star", text.str());
  const double exact = 1000 * 0.5 * 2.0 * std::sin(2.0 * std::numbers::pi / 1000);
  EXPECT_NEAR(areas(mesh).second, exact, 1e-11);
}

TEST_F(MeshIo, EqualPlacesOfAnStlBecomeOneVertex) {
  const std::vector<Vector3d> points = {{0, 0, 0},       {1, 0, 0}, {0, 1, 0},
                                        {-0.0, 0, -0.0}, {0, 1, 0}, {-1, 0, 0}};
  const TriangleMesh mesh = read_stl("two", binary_stl(points));
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}}));
}

TEST_F(MeshIo, WrongFilesAreRefusedByLineOrFacet) {
  struct Wrong {
    const char* name;
    std::string content;
    std::vector<const char*> parts;
  };
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", binary = binary_stl(box_triangles());
  std::string infinite = binary, counted = binary;
  std::memcpy(infinite.data() + 84 + 50 * 7 + 12 + 4, "\x00\x00\x80\x7f", 4);
  counted[80] = '\x7f', counted[83] = '\x7f';
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  const std::vector<Wrong> wrong = {
      {"a.obj", "", {"a.obj", "no faces"}},
      {"a.obj", three, {"no faces", "at least one"}},
      {"a.obj", three + "f 1 2 4\n", {"a.obj:4:", "vertex index = 4", "1 to 3"}},
      {"a.obj", "f 1 2 3\n", {":1:", "vertex index = 1", "1 to 0"}},
      {"a.obj", three + "\nf 1 2 99999999999\n", {":5:", "vertex index = 99999999999"}},
      {"a.obj", three + "f 1 2 99999999999999999999\n", {":4:", "'99999999999999999999'", "vertex index"}},
      {"a.obj", three + "f 0 1 2\n", {":4:", "'0'", "not 0"}},
      {"a.obj", three + "f 1 2 -4\n", {":4:", "'-4'", "of 3"}},
      {"a.obj", three + "f 1 2 -9223372036854775808\n", {":4:", "counted back"}},
      {"a.obj", three + "f 1 2\n", {":4:", "face with 2 vertices", "3 to 1000"}},
      {"a.obj", three + "f\n", {":4:", "face with 0 vertices"}},
      {"a.obj", three + "f 1.5 2 3\n", {":4:", "'1.5'", "vertex index"}},
      {"a.obj", three + "f 1 2 abc\n", {":4:", "'abc'"}},
      {"a.obj", three + "f 1/ 2 3\n", {":4:", "'1/'"}},
      {"a.obj", three + "f 1/2/3/4 2 3\n", {":4:", "'1/2/3/4'"}},
      {"a.obj", three + "f /1 2 3\n", {":4:", "'/1'"}},
      {"a.obj", "v 0 0\n", {":1:", "the end of the line", "coordinate"}},
      {"a.obj", "v 0 0", {":1:", "the end of the file"}},
      {"a.obj", "v 0 nan 0\n", {":1:", "'nan'", "finite"}},
      {"a.obj", "v 0 0 0\nv inf 0 0\n", {":2:", "'inf'"}},
      {"a.obj", "v 0 1e999 0\n", {":1:", "'1e999'"}},
      {"a.obj", "v 0 1,5 0\n", {":1:", "'1,5'"}},
      {"a.obj", "v 0 +-1 0\n", {":1:", "'+-1'"}},
      {"a.obj", "v 1 2 3 0.5\n", {":1:", "'0.5'", "weight of 1"}},
      {"a.obj", "v 1 2 3 4 5\n", {":1:", "'5'", "a colour of 3"}},
      {"a.obj", "v 1 2 3 1 1 1 1\n", {":1:", "3 coordinates"}},
      {"a.obj", "vertex 0 0 0\n", {":1:", "'vertex'", "v, f or another keyword"}},
      {"a.obj", "v 0 0 0\ncurv 0 1 1 2\n", {":2:", "'curv'"}},
      {"a.obj", three + "v 0 2 0\nv 1 -1 0\nf 1 2 3 4 5\n", {":6:", "5 vertices", "cross itself"}},
      {"a.obj", three + "v 1 1 0\nf 1 4 2 3\n", {":5:", "4 vertices", "cross itself"}},
      {"a.stl", "", {"0 bytes", "84 bytes"}},
      {"a.stl", binary.substr(0, 83), {"83 bytes"}},
      {"a.stl", binary.substr(0, binary.size() - 1), {"12 facets in a file of 683 bytes", "684 bytes"}},
      {"a.stl", binary + "x", {"12 facets", "685"}},
      {"a.stl", counted, {"2130706559 facets", "684 bytes"}},
      {"a.stl", binary_stl({}), {"no facets"}},
      {"a.stl", infinite, {"facet 7", "coordinate = inf"}},
      {"a.stl", "solid x\nendsolid x\n", {"no facets"}},
      {"a.stl", "solid x\n" + facet, {":8:", "the end of the file", "'facet' or 'endsolid'"}},
      {"a.stl", "solid x\n" + facet.substr(0, 60) + "\n", {"a.stl:6:", "'vert'", "expected 'vertex'"}},
      {"a.stl",
       "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
       {":6:", "'endloop'", "'vertex'"}},
      {"a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n", {":4:", "'nan'", "finite"}},
      {"a.stl",
       "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\nvertex 1 0 0\n",
       {":4:", "the end of the line"}},
      {"a.stl", "solid x\nfact normal\n", {":2:", "'fact'"}},
      {"a.stl", "solid x\n" + facet + "endsolid\nmore\n", {":10:", "'more'", "'solid' or the end"}},
      {"a.ply", "ply", {"a.ply", ".obj or .stl"}}};
  EXPECT_GE(wrong.size(), 20u);
  for (const Wrong& w : wrong) {
    const std::string text = message(w.name, w.content);
    for (const char* part : w.parts)
      EXPECT_NE(text.find(part), std::string::npos) << text << "\nlacks " << part;
  }
}

TEST_F(MeshIo, FilesThatAreNoneAndFilesTooLargeAreRefused) {
  const auto refused = [](const std::filesystem::path& path) -> std::string {
    try {
      static_cast<void>(read_mesh(path));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(refused(folder_.path() / "none.obj").find("none.obj: no such file"), std::string::npos);
  std::filesystem::create_directory(folder_.path() / "folder.stl");
  EXPECT_NE(refused(folder_.path() / "folder.stl").find("no such file"), std::string::npos);
  const auto large = write("large.stl", "");
  std::filesystem::resize_file(large, kLargestMeshFile + 1);  // sparse
  EXPECT_NE(refused(large).find("size = 268435457 bytes, expected at most 256 MiB"), std::string::npos);
}

TEST_F(MeshIo, MutatedFilesGiveAMeshOrAnInputError) {
  constexpr std::uint64_t kSeed = 12;
  RecordProperty("seed", std::to_string(kSeed));
  Random random(kSeed);
  const std::string originals[] = {box_obj(), box_ascii_stl(), binary_stl(box_triangles(), "binary")};
  static constexpr const char* kPieces[] = {
      "nan", "-1",     "1e999", "\n",      " ",
      "f ",  "v ",     "/",     "0",       "99999999999",
      "#",   "vertex", "solid", "endloop", std::string_view("\0", 1).data()};
  int accepted = 0, refused = 0;
  for (int i = 0; i < 5000; ++i) {
    const int kind = i % 3;
    std::string text = originals[kind];
    for (int changes = 1 + random.below(3); changes > 0; --changes) {
      const auto at = static_cast<std::size_t>(random.below(static_cast<int>(text.size())));
      switch (random.below(4)) {
        case 0:
          text[at] = static_cast<char>(random.below(256));
          break;
        case 1:
          text.erase(at, static_cast<std::size_t>(1 + random.below(20)));
          break;
        case 2:
          text.insert(at, kPieces[random.below(static_cast<int>(std::size(kPieces)))]);
          break;
        default:
          text.insert(at,
                      text.substr(static_cast<std::size_t>(random.below(static_cast<int>(text.size()))), 40));
      }
      if (text.empty()) text = " ";
    }
    try {
      const TriangleMesh mesh = kind == 0 ? read_obj("mutant", text) : read_stl("mutant", text);
      ++accepted;
      EXPECT_FALSE(mesh.triangles.empty());
      for (const Vector3d& x : mesh.vertices) EXPECT_TRUE(x.allFinite());
      for (const auto& triangle : mesh.triangles)
        for (const int vertex : triangle) {
          EXPECT_GE(vertex, 0);
          EXPECT_LT(vertex, static_cast<int>(mesh.vertices.size()));
        }
    } catch (const InputError& error) {
      ++refused;
      EXPECT_NE(std::string(error.what()).find("mutant"), std::string::npos);
    }
  }
  EXPECT_GT(accepted, 300);  // 444
  EXPECT_GT(refused, 3000);
}

}  // namespace
}  // namespace feder
