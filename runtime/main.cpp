#include "nodes/registry.hpp"
#include "nodes/wire_types.hpp"

int main()
{
    for (const auto& [name, type] : nodes::registry().types()) std::printf("%s\n", name.c_str());
    std::printf("%zu\n", graph::Value::of(geometry::TriMesh{}).bytes() +
                             graph::Value::of(geometry::Cubes{}).bytes() +
                             graph::Value::of(physics::Collider{}).bytes() +
                             graph::Value::of(physics::State{}).bytes() +
                             graph::Value::of(geometry::Samples{}).bytes());
}
