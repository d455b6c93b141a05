#include "models/scene_file/assembly.h"
#include "models/scene_file/functions.h"

namespace feder {

void Assembly::add_forces() {
  std::vector<ForceField> fields;  // `nodes` of bodies are -1 - body until the system is known
  for (const ForceEntry& entry : document_.forces) {
    const Named* named = look_up(entry, entry.on.name, {Kind::kParticle, Kind::kBody, Kind::kGroup},
                                 "a particle, a body or a group");
    if (!named) continue;
    std::vector<int> members = {named->index};
    if (named->kind == Kind::kGroup) members = scene_.groups[static_cast<std::size_t>(named->index)].members;
    Vector3d constant = Vector3d::Zero();
    std::array<std::optional<Expression>, 3> parts;
    bool varies = false, sound = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const FunctionText& text = entry.force[c];
      if (text.kind == FunctionText::Kind::kTable) {
        tell(entry, text.place, "force = a table, expected a number or an expression");
        sound = false;
        continue;
      }
      varies = varies || text.kind == FunctionText::Kind::kExpression;
      constant[static_cast<Eigen::Index>(c)] = text.number;
      parts[c] = expression_of(text, kForceVariables, entry.label + ": force", problems_);
      sound = sound && parts[c];
    }
    if (!sound) continue;
    ForceField field{{*parts[0], *parts[1], *parts[2]}, {}};
    for (int member : members) {
      const SceneNode& node = scene_.nodes[static_cast<std::size_t>(member)];
      if (!varies)
        attempt(entry, [&] { builder_.add_constant_force({node.node, node.body}, constant); });
      else
        field.nodes.push_back(node.body >= 0 ? -1 - node.body : node.node);
    }
    if (varies) fields.push_back(field);
  }
  if (!fields.empty() && problems_.empty()) set_fields(fields);
}

// Centres of bodies have node numbers only in a built system: built once without these forces to learn them.
void Assembly::set_fields(std::vector<ForceField>& fields) {
  attempt(document_, [&] {
    bool bodies = false;
    for (const ForceField& field : fields)
      for (int node : field.nodes) bodies = bodies || node < 0;
    if (bodies) {
      const System without = builder_.build().system;
      for (ForceField& field : fields)
        for (int& node : field.nodes)
          if (node < 0) node = without.bodies[static_cast<std::size_t>(-1 - node)].centre;
    }
    builder_.set_user_force(force_from(fields));
  });
}

void Assembly::add_torques() {
  for (const TorqueEntry& entry : document_.torques)
    if (const Named* named = look_up(entry, entry.on, {Kind::kBody}, "a body"))
      attempt(entry, [&] { builder_.add_constant_torque(named->anchor, entry.torque); });
}

}  // namespace feder
