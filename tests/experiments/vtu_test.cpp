// Frames for viewers: well-formed XML whose arrays, decoded here, are the scene's.
#include "experiments/support/vtu.h"

#include <gtest/gtest.h>

#include <cstring>
#include <stdexcept>

#include "engine/kkt.h"
#include "experiments/support/base64.h"
#include "tests/experiments/frame_sample.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

constexpr std::int64_t kFrames = 3;

std::string base64(std::string_view bytes) {
  std::string text(base64_size(bytes.size()), '?');
  encode_base64(bytes, text.data());
  return text;
}

TEST(Base64, GivesTheTestVectorsOfTheStandard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xfb\xff\xbe"), "+/++");
}

std::string decode(std::string_view text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, count = 0;
  for (const char c : text) {
    if (c == '=') break;
    const std::size_t digit = digits.find(c);
    if (digit == std::string::npos) throw std::runtime_error("no base64");
    bits = bits << 6 | static_cast<unsigned>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 255);
  }
  return bytes;
}

/// The values of the DataArray with this name.
template <class Number>
std::vector<Number> array(const std::string& xml, const std::string& type, const std::string& name) {
  const std::size_t tag = xml.find("<DataArray type=\"" + type + "\" Name=\"" + name + "\"");
  if (tag == std::string::npos) throw std::runtime_error("no array " + name);
  const std::size_t begin = xml.find('\n', tag) + 1;
  const std::string bytes = decode(std::string_view(xml).substr(begin, xml.find('\n', begin) - begin));
  std::uint64_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof size);
  EXPECT_EQ(size + sizeof size, bytes.size()) << name;
  std::vector<Number> values(size / sizeof(Number));
  std::memcpy(values.data(), bytes.data() + sizeof size, size);
  return values;
}

/// The first offence against XML's rules of nesting, tags and attributes; empty if there is none.
std::string malformed(std::string_view xml) {
  std::vector<std::string> open;
  bool rooted = false;
  if (!xml.starts_with("<?xml version=\"1.0\"?>\n")) return "no declaration";
  for (std::size_t at = xml.find("?>") + 2; at < xml.size();) {
    if (xml[at] != '<') {
      if (xml[at] == '&' || xml[at] == '>') return "a bare & or >";
      if (open.empty() && xml[at] != '\n') return "text outside the root";
      ++at;
      continue;
    }
    const std::size_t end = xml.find('>', at);
    if (end == std::string_view::npos) return "a tag without end";
    std::string_view tag = xml.substr(at + 1, end - at - 1);
    at = end + 1;
    if (tag.starts_with('/')) {
      if (open.empty() || open.back() != tag.substr(1)) return "closes " + std::string(tag);
      open.pop_back();
      continue;
    }
    if (open.empty() && rooted) return "two roots";
    rooted = true;
    const bool empty = tag.ends_with('/');
    if (empty) tag.remove_suffix(1);
    const std::size_t name = std::min(tag.find(' '), tag.size());
    if (!empty) open.emplace_back(tag.substr(0, name));
    for (tag.remove_prefix(name); !tag.empty();) {  // attributes: space, name, =", value, "
      const std::size_t equals = tag.find("=\""), quote = tag.find('"', equals + 2);
      if (tag[0] != ' ' || equals < 2 || quote == std::string_view::npos)
        return "attributes of " + std::string(tag);
      if (tag.substr(equals + 2, quote - equals - 2).find_first_of("<&") != std::string_view::npos)
        return "a bare < or & in " + std::string(tag);
      tag.remove_prefix(quote + 1);
    }
  }
  return open.empty() ? "" : open.back() + " is not closed";
}

struct Written {
  Scene scene = sample_scene();
  TemporaryFolder folder;
  Written() { write_sample(scene, kFrames, folder.path()); }
  std::string frame(std::int64_t i) const {
    return read_file(folder.path() / ("frames/frame_00000" + std::to_string(i) + ".vtu"));
  }
};

TEST(Vtu, IsWellFormed) {
  const Written written;
  for (std::int64_t i = 0; i < kFrames; ++i) EXPECT_EQ(malformed(written.frame(i)), "");
  EXPECT_NE(malformed("<?xml version=\"1.0\"?>\n<a><b></a></b>"), "");
  EXPECT_NE(malformed("<?xml version=\"1.0\"?>\n<a b=\"1\" c=2></a>"), "");
}

TEST(Pvd, ListsEveryFrameWithItsTime) {
  const Written written;
  EXPECT_EQ(read_file(written.folder.path() / "sample_1_2.pvd"),
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n"
            "<DataSet timestep=\"0\" group=\"\" part=\"0\" file=\"frames/frame_000000.vtu\"/>\n"
            "<DataSet timestep=\"0.1\" group=\"\" part=\"0\" file=\"frames/frame_000001.vtu\"/>\n"
            "<DataSet timestep=\"0.2\" group=\"\" part=\"0\" file=\"frames/frame_000002.vtu\"/>\n"
            "</Collection>\n</VTKFile>\n");
  EXPECT_EQ(malformed(read_file(written.folder.path() / "sample_1_2.pvd")), "");
}

TEST(Vtu, HoldsTheTime) {
  const Written written;
  for (std::int64_t i = 0; i < kFrames; ++i)
    EXPECT_EQ(array<double>(written.frame(i), "Float64", "TimeValue"),
              std::vector{0.1 * static_cast<double>(i)});
}

TEST(Vtu, PutsNodesThenAnchorsThenSurfacesWhereTheyAre) {
  const Written written;
  const Scene& scene = written.scene;
  const System& s = scene.model.system;
  for (std::int64_t i = 0; i < kFrames; ++i) {
    const State state = sample_state(scene, i);
    const std::vector<double> points = array<double>(written.frame(i), "Float64", "Points"),
                              velocities = array<double>(written.frame(i), "Float64", "velocity");
    ASSERT_EQ(points.size(), velocities.size());
    const auto expect_at = [&](std::size_t k, const Anchor& anchor) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(points[3 * k + c], position(s, anchor, state.q)[c]) << k;
        EXPECT_EQ(velocities[3 * k + c], velocity(s, anchor, state)[c]) << k;
      }
    };
    for (std::size_t k = 0; k < scene.nodes.size(); ++k) expect_at(k, {.node = scene.nodes[k].node});
    const std::vector<Vector3d>& vertices = scene.surfaces[0].vertices;
    const std::size_t first = points.size() / 3 - vertices.size();
    EXPECT_GT(first, scene.nodes.size());  // anchors lie between
    for (std::size_t k = 0; k < vertices.size(); ++k) expect_at(first + k, {.body = 1, .point = vertices[k]});
  }
}

TEST(Vtu, ConnectsWhatRowsConnect) {
  const Written written;
  const Scene& scene = written.scene;
  const State state = sample_state(scene, 1);
  const std::string frame = written.frame(1);
  const auto points = array<double>(frame, "Float64", "Points");
  const auto connectivity = array<std::int32_t>(frame, "Int32", "connectivity");
  const auto offsets = array<std::int32_t>(frame, "Int32", "offsets");
  const auto types = array<std::uint8_t>(frame, "UInt8", "types");
  const auto kinds = array<std::int32_t>(frame, "Int32", "kind");
  std::size_t cell = 0, corner = 0;
  const auto expect_cell = [&](int type, int kind, std::initializer_list<Anchor> places) {
    EXPECT_EQ(types.at(cell), type);
    EXPECT_EQ(kinds.at(cell), kind);
    for (const Anchor& place : places) {
      const Eigen::Map<const Vector3d> x(points.data() + 3 * connectivity.at(corner++));
      EXPECT_EQ(Vector3d(x), position(scene.model.system, place, state.q)) << cell;
    }
    EXPECT_EQ(offsets.at(cell++), static_cast<int>(corner));
  };
  for (const SceneNode& node : scene.nodes) expect_cell(1, 0, {{.node = node.node}});
  for (const SceneRow& row : scene.rows) {
    expect_cell(3, 1, {row.nodes[0], row.nodes[1]});
    if (row.nodes.size() == 3) expect_cell(3, 1, {row.nodes[1], row.nodes[2]});
  }
  const SceneSurface& surface = scene.surfaces[0];
  for (const auto& t : surface.triangles)
    expect_cell(5, 2,
                {{.body = 1, .point = surface.vertices[t[0]]},
                 {.body = 1, .point = surface.vertices[t[1]]},
                 {.body = 1, .point = surface.vertices[t[2]]}});
  EXPECT_EQ(cell, types.size());
}

TEST(Vtu, ShowsForcesOfRowsAndStrainsOfDistanceRows) {
  const Written written;
  const Scene& scene = written.scene;
  const System& s = scene.model.system;
  int strained = 0;
  for (std::int64_t i = 0; i < kFrames; ++i) {
    VectorXd phi;
    evaluate_phi(s, sample_state(scene, i).q, phi);
    const VectorXd lambda = i == 0 ? VectorXd::Zero(s.rows).eval() : sample_history(scene, i).lambda;
    std::vector<double> forces(scene.nodes.size()), strains = forces;
    for (const SceneRow& row : scene.rows) {
      const double force = row.rows == 1 ? lambda[row.first_row] : lambda.segment<3>(row.first_row).norm();
      double strain = 0.0;
      if (row.type == "anchor distance") strain = phi[row.first_row] / 2.5;
      if (row.type == "distance" && s.distance.rest[row.first_row] > 0.0)  // one has rest length 0
        strain = phi[row.first_row] / s.distance.rest[row.first_row];
      strained += strain != 0.0;
      forces.insert(forces.end(), row.nodes.size() - 1, force);
      strains.insert(strains.end(), row.nodes.size() - 1, strain);
    }
    forces.resize(forces.size() + scene.surfaces[0].triangles.size());
    strains.resize(forces.size());
    const std::vector<double> found = array<double>(written.frame(i), "Float64", "row_force");
    ASSERT_EQ(found.size(), forces.size());
    const std::size_t cells = forces.size() - scene.surfaces[0].triangles.size();
    for (std::size_t c = 0; c < found.size(); ++c)
      if (i == 0 && c >= scene.nodes.size() && c < cells)
        EXPECT_TRUE(std::isnan(found[c])) << c;  // the first frame has no forces yet
      else
        EXPECT_EQ(found[c], forces[c]) << i << " " << c;
    EXPECT_EQ(array<double>(written.frame(i), "Float64", "strain"), strains);
  }
  EXPECT_EQ(strained, 9);  // two distance rows and an anchor distance row in three frames
}

}  // namespace
}  // namespace feder::experiments
