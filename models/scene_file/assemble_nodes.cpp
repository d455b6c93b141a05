#include <algorithm>
#include <cmath>

#include "models/scene_file/assembly.h"
#include "models/scene_file/functions.h"
#include "models/scene_file/shapes.h"

namespace feder {

Anchor Assembly::add_particle(double mass, const Vector3d& position, const Vector3d& velocity,
                              FreeMask free) {
  const Anchor anchor = builder_.add_particle(mass, position, velocity, free);
  places_.resize(static_cast<std::size_t>(anchor.node) + 1);
  places_.back() = position;
  return anchor;
}

Anchor Assembly::add_point(const Vector3d& position) {
  const Anchor anchor = builder_.add_world_point(position);
  places_.resize(static_cast<std::size_t>(anchor.node) + 1);
  places_.back() = position;
  return anchor;
}

Anchor Assembly::add_body(const MassProperties& properties, const SystemBuilder::BodyStart& start) {
  const Anchor anchor = builder_.add_body(properties, start);
  poses_.push_back({start.position, start.orientation});
  return anchor;
}

void Assembly::add_points() {
  for (const PointEntry& entry : document_.points) {
    if (!claim(entry, entry.name)) continue;
    names_[entry.name.value] = {};
    if (entry.broken && entry.group.given) names_.emplace(entry.group.value, Named{});
    if (entry.broken) continue;
    const bool moves = entry.motion[0].kind != FunctionText::Kind::kNone;
    if (moves == entry.position.given) {
      tell(entry, entry.place,
           moves ? "it has both position and motion, expected one" : "'position' or 'motion' is missing");
      continue;
    }
    attempt(entry, [&] {
      Anchor anchor;
      if (moves) {
        std::array<Target, 3> components;
        for (std::size_t c = 0; c < 3; ++c) {
          const auto component = target_of(entry.motion[c], entry.label + ": motion", problems_);
          if (!component) return;
          components[c] = *component;
        }
        const Motion motion = motion_from(components);
        anchor = builder_.add_moving_point(motion);
        places_.resize(static_cast<std::size_t>(anchor.node) + 1);
        places_.back() = motion.position(0.0);
      } else {
        anchor = add_point(entry.position.value);
      }
      name_node(entry, entry.name.value, SceneNode::Kind::kPoint, anchor, entry.group);
    });
  }
}

void Assembly::add_particles() {
  for (const ParticleEntry& entry : document_.particles) {
    if (!claim(entry, entry.name)) continue;
    names_[entry.name.value] = {};
    if (entry.broken && entry.group.given) names_.emplace(entry.group.value, Named{});
    if (entry.broken) continue;
    const bool fixed = std::isinf(entry.mass);
    if (fixed && !entry.velocity.value.isZero(0.0)) {
      tell(entry, entry.velocity.place, "velocity of a fixed particle, expected none");
      continue;
    }
    attempt(entry, [&] {
      const Anchor anchor = fixed
                                ? add_point(entry.position)
                                : add_particle(entry.mass, entry.position, entry.velocity.value, entry.free);
      name_node(entry, entry.name.value, SceneNode::Kind::kParticle, anchor, entry.group);
    });
  }
}

void Assembly::add_bodies() {
  for (const BodyEntry& entry : document_.bodies) {
    if (!claim(entry, entry.name)) continue;
    names_[entry.name.value] = {};
    if (entry.broken && entry.group.given) names_.emplace(entry.group.value, Named{});
    if (entry.broken) continue;
    const bool fixed = entry.mass.given && std::isinf(entry.mass.value);
    ShapeKeys keys = entry;
    if (fixed) keys.mass.value = 1.0;
    if (fixed && entry.shape.value == ShapeKeys::kParts) keys.mass.given = false;
    ShapeReader reader{limits_.folder, limits_.allow_outside, problems_};
    const std::optional<BodyShape> shape = reader.read(entry.label, entry.place, keys, entry.parts);
    if (!shape) continue;
    SystemBuilder::BodyStart start{
        entry.position,         entry.orientation.axes,       entry.velocity,
        entry.angular_velocity, fixed ? kPinned : entry.free, fixed ? kPinned : entry.free_spin};
    attempt(entry, [&] {
      const Anchor anchor = add_body(shape->properties, start);
      name_node(entry, entry.name.value, SceneNode::Kind::kBody, anchor, entry.group);
      if (!shape->surface.triangles.empty()) {
        scene_.surfaces.push_back(shape->surface);
        scene_.surfaces.back().body = anchor.body;
      }
    });
  }
}

}  // namespace feder
