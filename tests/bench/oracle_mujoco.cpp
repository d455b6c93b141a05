// MuJoCo: free bodies, joints as soft <equality><connect> rows, solver Newton, the engine's own solref and
// solimp, no contacts.
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cstring>

#include "engine/check.h"
#include "tests/bench/oracle_simulator.h"

namespace feder {
namespace {

constexpr const char* kFile = "scene.xml";

std::string text(const Vector3d& x) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", x.x(), x.y(), x.z());
}

std::string body_text(const Model& model, int i) {
  const Pose pose = pose_of(model.system, model.state, i);
  const Eigen::Quaterniond q(pose.axes);
  return fmt::format(
      "<body name=\"b{}\" pos=\"{}\" quat=\"{:.17g} {:.17g} {:.17g} {:.17g}\"><freejoint/>"
      "<inertial pos=\"0 0 0\" mass=\"{:.17g}\" diaginertia=\"{}\"/></body>\n",
      i, text(pose.centre), q.w(), q.x(), q.y(), q.z(), mass_of(model.system, i),
      text(box_inertia_of(model.system, i)));
}

std::string connect_text(const BallRow& joint) {
  if (joint.a.body < 0)
    return fmt::format("<connect body1=\"b{}\" anchor=\"{}\"/>\n", joint.b.body, text(joint.b.point));
  const std::string second = joint.b.body < 0 ? "" : fmt::format(" body2=\"b{}\"", joint.b.body);
  return fmt::format("<connect body1=\"b{}\"{} anchor=\"{}\"/>\n", joint.a.body, second, text(joint.a.point));
}

std::string scene_text(const Model& model) {
  std::string bodies, joints;
  for (int i = 0; i < std::ssize(model.system.bodies); ++i) bodies += body_text(model, i);
  for (const BallRow& joint : joints_of(model.system)) joints += connect_text(joint);
  return fmt::format(
      "<mujoco><option gravity=\"{}\" solver=\"Newton\"><flag contact=\"disable\"/></option>\n"
      "<default><geom contype=\"0\" conaffinity=\"0\"/></default>\n"
      "<size njmax=\"{}\" nconmax=\"1\"/>\n<worldbody>\n{}</worldbody>\n<equality>\n{}</equality></mujoco>\n",
      text(model.system.forces.gravity), 3 * joints_of(model.system).size(), bodies, joints);
}

class Mujoco : public Simulator {
 public:
  explicit Mujoco(const Model& model) {
    const std::string scene = scene_text(model);
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), kFile, static_cast<int>(scene.size()));
    std::memcpy(files->filedata[0], scene.data(), scene.size());
    char error[1000] = "";
    model_ = mj_loadXML(kFile, files.get(), error, sizeof error);
    mj_deleteVFS(files.get());
    if (!model_) throw InputError(std::string("MuJoCo: ") + error);
    data_ = mj_makeData(model_);
  }
  ~Mujoco() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  const char* name() const override { return "MuJoCo Newton"; }
  Status step(double dt) override {
    model_->opt.timestep = dt;
    mj_step(model_, data_);
    for (int i = 0; i < mjNWARNING; ++i)
      if (data_->warning[i].number > 0)
        return Status::failure(StatusCode::kNonFinite,
                               std::string("MuJoCo: ") + mju_warningText(i, data_->warning[i].lastinfo));
    return {};
  }
  Pose pose(int body) const override {
    const mjtNum* q = data_->qpos + 7 * body;
    return {{q[0], q[1], q[2]}, Eigen::Quaterniond(q[3], q[4], q[5], q[6]).toRotationMatrix()};
  }

 private:
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
};

}  // namespace

SimulatorPtr make_mujoco(const Model& model) {
  return std::make_unique<Mujoco>(model);
}

}  // namespace feder
