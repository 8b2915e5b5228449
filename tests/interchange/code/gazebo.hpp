// Stand-in for what the plug-in uses of Gazebo: names and signatures of the public headers of gz-sim, gz-math,
// gz-msgs, gz-transport and sdformat, with bodies that play one sensor at rest.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace gz::math {
struct Vector3d {
  double x = 0, y = 0, z = 0;
  Vector3d() = default;
  Vector3d(double a, double b, double c) : x(a), y(b), z(c) {}
  double X() const { return x; }
  double Y() const { return y; }
  double Z() const { return z; }
  Vector3d operator-(const Vector3d& o) const { return {x - o.x, y - o.y, z - o.z}; }
};
struct Quaterniond {
  Quaterniond Inverse() const { return *this; }
  Vector3d RotateVector(const Vector3d& v) const { return v; }
};
struct Pose3d {
  Quaterniond Rot() const { return {}; }
};
}  // namespace gz::math
namespace gz::msgs {
struct Time {
  double seconds = 0;
};
struct Header {
  Time stamp;
  Time* mutable_stamp() { return &stamp; }
};
struct IMU {
  Header header;
  std::string name;
  gz::math::Vector3d rate, force;
  Header* mutable_header() { return &header; }
  void set_entity_name(const std::string& n) { name = n; }
  gz::math::Vector3d* mutable_angular_velocity() { return &rate; }
  gz::math::Vector3d* mutable_linear_acceleration() { return &force; }
};
inline Time Convert(const std::chrono::steady_clock::duration& d) { return {std::chrono::duration<double>(d).count()}; }
inline void Set(gz::math::Vector3d* out, const gz::math::Vector3d& in) { *out = in; }
}  // namespace gz::msgs
namespace gz::transport {
struct Node {
  struct Publisher {
    bool Publish(const gz::msgs::IMU& m) {
      std::printf("%.17g %.17g %.17g\n", m.header.stamp.seconds, m.rate.x, m.force.z);
      return true;
    }
  };
  template <typename T>
  Publisher Advertise(const std::string&) {
    return {};
  }
};
}  // namespace gz::transport
namespace sdf {
struct Element {
  template <typename T>
  std::pair<T, bool> Get(const std::string&, const T& value) const {
    return {value, false};
  }
};
}  // namespace sdf
#define gzerr std::cerr
namespace gz::sim {
using Entity = std::uint64_t;
struct EventManager {};
struct UpdateInfo {
  std::chrono::steady_clock::duration simTime{0}, realTime{0}, dt{0};
  std::uint64_t iterations = 0;
  bool paused = true;
};
template <typename T>
struct Component {
  T data;
  const T& Data() const { return data; }
};
namespace components {
struct World {};
struct Imu {};
struct Name : Component<std::string> {};
struct Gravity : Component<math::Vector3d> {};
struct WorldPose : Component<math::Pose3d> {};
struct AngularVelocity : Component<math::Vector3d> {};
struct LinearAcceleration : Component<math::Vector3d> {};
}  // namespace components
struct EntityComponentManager {
  Entity EntityByComponents(const components::World&) const { return 1; }
  template <typename T>
  const T* Component(Entity) const {
    static const T gravity{{{0, 0, -9.8}}};
    return &gravity;
  }
  template <typename... T, typename F>
  void Each(F function) const {
    const std::tuple<T...> parts{};
    function(Entity{2}, &std::get<T>(parts)...);
  }
};
struct System {
  virtual ~System() = default;
};
struct ISystemConfigure {
  virtual ~ISystemConfigure() = default;
  virtual void Configure(const Entity&, const std::shared_ptr<const sdf::Element>&, EntityComponentManager&,
                         EventManager&) = 0;
};
struct ISystemPostUpdate {
  virtual ~ISystemPostUpdate() = default;
  virtual void PostUpdate(const UpdateInfo&, const EntityComponentManager&) = 0;
};
}  // namespace gz::sim
#define GZ_ADD_PLUGIN(plugin, ...) static plugin g_plugin;
