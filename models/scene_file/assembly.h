// From a document to a system: looks names up, adds nodes, rows and forces, remembers what is called how.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/joints.h"
#include "models/scene_file/entries.h"
#include "models/scene_file/laws.h"
#include "models/scene_file/scene.h"

namespace feder {

/// What a scene may cost, and where its mesh files may lie.
struct AssemblyLimits {
  double most_nodes, most_rows;
  std::filesystem::path folder;
  bool allow_outside;
};

class Assembly {
 public:
  Assembly(const Document& document, const AssemblyLimits& limits, Diagnostics& problems);

  /// The scene; to be used only if there were no problems. Its model has neither name nor times yet.
  Scene build();
  /// After build(): what is no error but will surprise, one sentence each.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  enum class Kind { kParticle, kPoint, kBody, kGroup, kBroken };
  /// What a name stands for. Broken: an entry whose problem has been told already.
  struct Named {
    Kind kind = Kind::kBroken;
    Anchor anchor = {};
    int index = -1;  // into scene_.nodes or scene_.groups
  };
  struct Pose {
    Vector3d position = Vector3d::Zero();
    Matrix3d axes = Matrix3d::Identity();
  };

  // Runs an action of the engine; what it throws becomes a problem at the entry.
  template <class Action>
  bool attempt(const Entry& entry, Action&& action);
  void tell(const Entry& entry, TextPlace place, const std::string& message);

  // names
  bool claim(const Entry& entry, const NameText& name);
  void name_node(const Entry& entry, const std::string& name, SceneNode::Kind kind, const Anchor& anchor,
                 const NameText& group);
  int group(const std::string& name);
  const Named* look_up(const Entry& entry, const NameText& name, const std::vector<Kind>& kinds,
                       const char* expectation);

  // nodes
  Anchor add_particle(double mass, const Vector3d& position, const Vector3d& velocity, FreeMask free);
  Anchor add_point(const Vector3d& position);
  Anchor add_body(const MassProperties& properties, const SystemBuilder::BodyStart& start);
  void add_points();
  void add_particles();
  void add_bodies();

  // rows
  bool material_of(const Entry& entry, const MaterialKeys& keys, double default_stiffness, Material& out);
  bool anchor_of(const Entry& entry, const AnchorText& text, Anchor& out);
  bool ends_of(const Entry& entry, const std::vector<AnchorText>& between, Anchor& a, Anchor& b);
  bool bodies_of(const Entry& entry, const std::vector<AnchorText>& between, Anchor& a, Anchor& b);
  bool different(const Entry& entry, const AnchorText& second, const Anchor& a, const Anchor& b);
  Vector3d place_of(const Anchor& anchor) const;
  bool claim_row(const Entry& entry, const NameText& name, const std::string& type);
  void record(const Entry& entry, const NameText& name, const std::vector<int>& ids,
              const std::vector<std::string>& types, const std::vector<Anchor>& nodes);
  void add_springs();
  void add_law_springs();
  void add_bendings();
  void add_joints();
  void add_turns();
  void add_slides();
  void add_perpendiculars();
  void add_forces();
  void set_fields();
  void add_torques();

  // generators
  bool require_counts(const Entry& entry, double nodes, double rows);
  // The particles of a generator, in scene_.nodes from `first` on, the last index running fastest.
  struct Grid {
    std::array<int, 3> count{1, 1, 1};
    int dimensions = 1, first = 0;
    std::vector<Anchor> anchors = {};
    int at(int i, int j, int k) const { return (i * count[1] + j) * count[2] + k; }
  };
  struct GridNode {
    Vector3d position;
    bool fixed;
  };
  template <class At>
  bool add_grid(const Entry& entry, const NameText& name, double mass, Grid& grid, At&& node_at);
  // A spring from every node to the one `step` further, where there is one.
  void add_grid_springs(const Entry& entry, const Grid& grid, const std::array<int, 3>& step,
                        const Material& material);
  bool counts_of(const Entry& entry, const std::vector<double>& numbers, std::size_t wanted, Grid& grid);
  void add_chains();
  void add_cloths();
  void add_lattices();
  void add_nets();

  void close(Scene& scene, const System& system) const;
  void check_hard_rows(const Scene& scene);
  void check_start(const Scene& scene);

  const Document& document_;
  AssemblyLimits limits_;
  Diagnostics& problems_;
  SystemBuilder builder_;
  std::map<std::string, Named> names_;
  std::map<std::string, TextPlace> claimed_;
  std::map<std::string, const MaterialEntry*> materials_;
  std::vector<Vector3d> places_;  // of particles and points by node
  std::vector<Pose> poses_;       // of bodies
  struct Recorded {
    SceneRow row;
    int id;
    const Entry* entry;
  };
  std::vector<Recorded> rows_;
  std::vector<std::string> notes_;
  std::set<std::pair<std::string, std::string>> row_names_;  // of entries: name and type
  struct Field {
    const ForceEntry* entry;
    ForceField field;
  };
  std::vector<Field> fields_;                       // forces by expressions
  std::vector<const LawSpringEntry*> law_springs_;  // in the order of the system's
  double nodes_ = 0.0, row_count_ = 0.0;
  Scene scene_;
};

template <class Action>
bool Assembly::attempt(const Entry& entry, Action&& action) {
  if (entry.broken) return false;
  try {
    action();
    return true;
  } catch (const InputError& error) {
    tell(entry, entry.place, error.what());
    return false;
  }
}

}  // namespace feder
