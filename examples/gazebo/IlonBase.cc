// A system of Gazebo (gz-sim 8 and later) that lets ilon move the base link of a model: `ilon_base.hpp` under Gazebo's components.
//
//   <plugin filename="IlonBase" name="ilon::IlonBase">
//     <scenario>/path/to/base.toml</scenario>
//     <link>base_link</link>                <!-- the default -->
//     <topic>/model/NAME/cmd_vel</topic>    <!-- the default, of gz.msgs.Twist -->
//   </plugin>
//
// The link is the model's canonical link, without wheels, without gravity (<gravity>false</gravity>) and heavy: a hundred times what hangs on it.
#include <gz/msgs/twist.pb.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <gz/common/Console.hh>
#include <gz/plugin/Register.hh>
#include <gz/sim/Link.hh>
#include <gz/sim/Model.hh>
#include <gz/sim/System.hh>
#include <gz/transport/Node.hh>

#include "ilon_base.hpp"

namespace ilon {

using namespace gz::sim;

class IlonBase : public System, public ISystemConfigure, public ISystemPreUpdate, public ISystemReset {
 public:
  void Configure(const Entity& entity, const std::shared_ptr<const sdf::Element>& element, EntityComponentManager& ecm,
                 EventManager&) override try {
    model_ = Model(entity);
    const auto name = element->Get<std::string>("link", "base_link").first;
    link_ = Link(model_.LinkByName(ecm, name));
    if (!link_.Valid(ecm)) throw std::runtime_error("the model has no link `" + name + "`: name it in <link>");
    const auto [scenario, given] = element->Get<std::string>("scenario", "");
    if (!given) throw std::runtime_error("give the robot and its floor by <scenario>");
    link_.EnableVelocityChecks(ecm);
    base_ = std::make_unique<Base>(scenario);
    const auto topic = element->Get<std::string>("topic", "/model/" + model_.Name(ecm) + "/cmd_vel").first;
    node_.Subscribe(topic, &IlonBase::OnTwist, this);
  } catch (const std::exception& fault) {
    gzerr << "ilon: " << fault.what() << std::endl;
  }

  void PreUpdate(const UpdateInfo& info, EntityComponentManager& ecm) override try {
    if (!base_ || info.paused) return;
    const auto pose = link_.WorldPose(ecm);
    const auto inertial = link_.WorldInertial(ecm);
    if (!pose || !inertial) return;
    if (start_) {
      base_->reset(pose->Pos().X(), pose->Pos().Y(), pose->Rot().Yaw());
      start_ = false;
    }
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      base_->command_twist(asked_[0], asked_[1], asked_[2]);
    }
    Motion now;
    now.position = vector(pose->Pos());
    now.quaternion = {pose->Rot().W(), pose->Rot().X(), pose->Rot().Y(), pose->Rot().Z()};
    // Unknown before the first step, and not needed then.
    now.linear = vector(link_.WorldLinearVelocity(ecm).value_or(gz::math::Vector3d::Zero));
    now.angular = vector(link_.WorldAngularVelocity(ecm).value_or(gz::math::Vector3d::Zero));
    Inertia own, scene;
    for (const auto& entity : model_.Links(ecm)) {
      const Link link(entity);
      if (const auto of = link.WorldInertial(ecm)) add(entity == link_.Entity() ? own : scene, *of, pose->Pos());
    }
    const double step_s = std::chrono::duration<double>(info.dt).count();
    const auto [linear, angular] = base_->advance(step_s, now, own, scene);
    // Gazebo expects them in the link's frame.
    link_.SetLinearVelocity(ecm, pose->Rot().RotateVectorReverse({linear[0], linear[1], linear[2]}));
    link_.SetAngularVelocity(ecm, pose->Rot().RotateVectorReverse({angular[0], angular[1], angular[2]}));
  } catch (const std::exception& fault) {
    gzerr << "ilon: " << fault.what() << std::endl;
    base_.reset();
  }

  void Reset(const UpdateInfo&, EntityComponentManager&) override { start_ = true; }

 private:
  static Vector vector(const gz::math::Vector3d& v) { return {v.X(), v.Y(), v.Z()}; }
  static void add(Inertia& to, const gz::math::Inertiald& of, const gz::math::Vector3d& origin) {
    // Along the world's axes, about its centre.
    const auto moi = of.Moi();
    std::array<Vector, 3> rows;
    for (int row = 0; row < 3; ++row) rows[row] = {moi(row, 0), moi(row, 1), moi(row, 2)};
    to.add(of.MassMatrix().Mass(), vector(of.Pose().Pos() - origin), rows);
  }
  void OnTwist(const gz::msgs::Twist& twist) {
    const std::lock_guard<std::mutex> lock(mutex_);
    asked_ = {twist.linear().x(), twist.linear().y(), twist.angular().z()};
  }

  Model model_{kNullEntity};
  Link link_{kNullEntity};
  std::unique_ptr<Base> base_;
  gz::transport::Node node_;
  std::mutex mutex_;
  Vector asked_{};
  bool start_ = true;
};

}  // namespace ilon

GZ_ADD_PLUGIN(ilon::IlonBase, gz::sim::System, ilon::IlonBase::ISystemConfigure, ilon::IlonBase::ISystemPreUpdate,
              ilon::IlonBase::ISystemReset)
