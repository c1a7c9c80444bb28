// Cameras of a scene and how they move. Motion is sampled: chains of nodes that turn, move and
// scale by keys of their own have no simpler whole.

#include "geometry/io/assimp/jobs.hpp"

#include <assimp/scene.h>
#include <assimp/version.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace geometry::assimp {
namespace {

constexpr double longest = 3600;  // s, of a motion

using Matrix = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

std::string name_of(const aiString& s)
{
    return {s.data, std::min<std::size_t>(s.length, sizeof(s.data) - 1)};
}

Vec3f vector_of(const aiVector3D& v)
{
    return {float(v.x), float(v.y), float(v.z)};
}

Eigen::Vector3d mixed(const aiVector3D& a, const aiVector3D& b, double share)
{
    const Eigen::Vector3d from(a.x, a.y, a.z), to(b.x, b.y, b.z);
    return from + share * (to - from);
}

Eigen::Quaterniond mixed(const aiQuaternion& a, const aiQuaternion& b, double share)
{
    const Eigen::Quaterniond from(a.w, a.x, a.y, a.z), to(b.w, b.x, b.y, b.z);
    return from.normalized().slerp(share, to.normalized());
}

// The value at `ticks` of keys in order of time, of which there is one at least.
template <class Key> auto value_at(const Key* keys, unsigned count, double ticks)
{
    const Key* const after = std::upper_bound(
        keys, keys + count, ticks, [](double t, const Key& key) { return t < key.mTime; });
    const Key& to = after == keys + count ? keys[count - 1] : *after;
    const Key& from = after == keys ? keys[0] : *(after - 1);
    const double span = to.mTime - from.mTime;
    return mixed(from.mValue, to.mValue, span > 0 ? (ticks - from.mTime) / span : 0);
}

// A node on the way to a camera, and what moves it.
struct Step {
    Matrix still = Matrix::Identity();
    const aiNodeAnim* moves = nullptr;
    double ticks_a_second = 1, seconds = 0;

    Matrix at(double time) const
    {
        const bool whole = moves && moves->mNumPositionKeys > 0 && moves->mNumRotationKeys > 0 &&
                           moves->mNumScalingKeys > 0;
        if (!whole) return still;
        const double ticks = time * ticks_a_second;
        Eigen::Affine3d T = Eigen::Affine3d::Identity();
        T.translate(value_at(moves->mPositionKeys, moves->mNumPositionKeys, ticks));
        T.rotate(value_at(moves->mRotationKeys, moves->mNumRotationKeys, ticks));
        T.scale(value_at(moves->mScalingKeys, moves->mNumScalingKeys, ticks));
        return T.matrix();
    }
};

Step step_of(const aiScene& scene, const aiNode& node)
{
    Step step;
    step.still =
        Eigen::Map<const Eigen::Matrix<ai_real, 4, 4, Eigen::RowMajor>>(&node.mTransformation.a1)
            .cast<double>();
    for (unsigned a = 0; a < scene.mNumAnimations && !step.moves; ++a) {
        const aiAnimation& animation = *scene.mAnimations[a];
        for (unsigned c = 0; c < animation.mNumChannels; ++c) {
            if (animation.mChannels[c]->mNodeName != node.mName) continue;
            step.moves = animation.mChannels[c];
            step.ticks_a_second = animation.mTicksPerSecond > 0 ? animation.mTicksPerSecond : 25;
            const double last =
                std::max({step.moves->mNumPositionKeys > 0
                              ? step.moves->mPositionKeys[step.moves->mNumPositionKeys - 1].mTime
                              : 0,
                          step.moves->mNumRotationKeys > 0
                              ? step.moves->mRotationKeys[step.moves->mNumRotationKeys - 1].mTime
                              : 0});
            step.seconds = std::clamp(last / step.ticks_a_second, 0.0, longest);
            break;
        }
    }
    return step;
}

const aiNode* node_named(const aiScene& scene, const aiString& name)
{
    std::vector<const aiNode*> todo{scene.mRootNode};
    while (!todo.empty()) {
        const aiNode* const node = todo.back();
        todo.pop_back();
        if (!node) continue;
        if (node->mName == name) return node;
        todo.insert(todo.end(), node->mChildren, node->mChildren + node->mNumChildren);
    }
    return nullptr;
}

ImportedCamera camera_of(const aiScene& scene, const aiCamera& in)
{
    ImportedCamera out;
    out.name = name_of(in.mName);
    out.position = vector_of(in.mPosition);
    out.ahead = vector_of(in.mLookAt);
    out.up = vector_of(in.mUp);
    out.width_angle = in.mHorizontalFOV;
    out.half_width = in.mOrthographicWidth;
    out.aspect = in.mAspect;
    std::vector<Step> steps;  // from the camera's node up
    double seconds = 0;
    for (const aiNode* n = node_named(scene, in.mName); n; n = n->mParent) {
        steps.push_back(step_of(scene, *n));
        seconds = std::max(seconds, steps.back().seconds);
    }
    if (steps.empty()) return out;  // no node holds it
    const auto samples = std::size_t(std::ceil(seconds * ImportedCamera::samples_a_second)) + 1;
    for (std::size_t i = 0; i < samples; ++i) {
        Matrix world = Matrix::Identity();
        const double time = double(i) / ImportedCamera::samples_a_second;
        for (const Step& step : steps) world = step.at(time) * world;
        std::copy_n(world.data(), 12, out.to_world.emplace_back().begin());
    }
    return out;
}

}  // namespace

void read_cameras(const aiScene& scene, bool gltf, std::span<const ColladaLens> lenses,
                  ImportedScene& out)
{
    // Up to assimp 5.2 the width's angle of glTF is that of the height times the aspect, or itself
    // where the file says none.
    const unsigned version = 100 * aiGetVersionMajor() + aiGetVersionMinor();
    for (unsigned i = 0; i < scene.mNumCameras; ++i) {
        ImportedCamera& camera = out.cameras.emplace_back(camera_of(scene, *scene.mCameras[i]));
        const std::size_t lens = lens_number(scene.mCameras[i]->mClipPlaneFar);
        if (lens < lenses.size()) set_lens(lenses[lens], camera);
        if (!gltf) continue;
        camera.position = {0, 0, 0};  // assimp tells the move of its node a second time
        if (camera.half_width > 0) continue;
        if (camera.aspect <= 0) camera.aspect = 1;
        if (version > 502) continue;
        const float high = camera.width_angle / camera.aspect;
        camera.width_angle = 2 * std::atan(std::tan(0.5f * high) * camera.aspect);
    }
}

}  // namespace geometry::assimp
