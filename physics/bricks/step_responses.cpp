#include "physics/bricks/step_responses.hpp"

#include "geometry/base/parallel.hpp"

#include <Eigen/Eigenvalues>

#include <set>

namespace physics {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

StepResponses::Weights weights_of(const ContactBlock<float>& contact)
{
    StepResponses::Weights out;
    for (std::size_t a = 0; a < contact.count; ++a) {
        out.emplace_back(contact.corners[a], contact.weight[a]);
    }
    return out;
}

// G with G G^T = K.
Matrix3d root_of(const std::array<float, 6>& k)
{
    Matrix3d m;
    m << k[0], k[1], k[2], k[1], k[3], k[4], k[2], k[4], k[5];
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(m);
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

// W z
Vector3d at_contact(const ContactBlock<float>& contact, const float* z)
{
    Vector3d sum = Vector3d::Zero();
    for (std::size_t a = 0; a < contact.count; ++a) {
        const float* const from = z + 4 * std::size_t{contact.corners[a]};
        const auto weight = double(contact.weight[a]);
        sum += weight * Vector3d(double(from[0]), double(from[1]), double(from[2]));
    }
    return sum;
}

}  // namespace

void StepResponses::start(double step, const Aligned<double>& place)
{
    if (tau == step && linear_at == place) return;
    known.clear();
    tau = step;
    linear_at = place;
}

std::size_t StepResponses::missing(const std::vector<ContactBlock<float>>& contacts) const
{
    std::size_t sum = 0;
    for (const auto& contact : contacts) sum += known.count(weights_of(contact)) > 0 ? 0 : 3;
    return sum;
}

void StepResponses::keep(const std::vector<ContactBlock<float>>& contacts)
{
    std::set<Weights> wanted;
    for (const auto& contact : contacts) wanted.insert(weights_of(contact));
    std::erase_if(known, [&](const auto& one) { return wanted.count(one.first) == 0; });
}

void StepResponses::make(const std::vector<ContactBlock<float>>& contacts,
                         const Aligned<double>& fixed, std::size_t room, const Apply& inverse)
{
    Aligned<float> push(fixed.size(), 0);
    used_.clear();
    for (const auto& contact : contacts) {
        const auto [at, is_new] = known.try_emplace(weights_of(contact));
        for (std::size_t i = 0; is_new && i < 3; ++i) {
            const auto place = [&](std::size_t a) {
                return 4 * std::size_t{contact.corners[a]} + i;
            };
            for (std::size_t a = 0; a < contact.count; ++a) {
                if (fixed[place(a)] == 0) push[place(a)] += contact.weight[a];
            }
            at->second[i].assign(room, 0);
            inverse(push.data(), at->second[i].data());
            for (std::size_t a = 0; a < contact.count; ++a) push[place(a)] = 0;
        }
        used_.push_back({&contact, &at->second, root_of(contact.matrix)});
    }
    const auto m = static_cast<Index>(used_.size());
    Eigen::MatrixXd middle = Eigen::MatrixXd::Identity(3 * m, 3 * m);
    for (Index a = 0; a < m; ++a) {
        const Used& one = used_[std::size_t(a)];
        for (Index b = 0; b < m; ++b) {
            const Used& other = used_[std::size_t(b)];
            Matrix3d moved;
            for (Index i = 0; i < 3; ++i) {
                moved.col(i) = at_contact(*one.contact, (*other.response)[std::size_t(i)].data());
            }
            middle.block<3, 3>(3 * a, 3 * b) += one.root.transpose() * moved * other.root;
        }
    }
    middle_.compute(0.5 * (middle + middle.transpose()));
    if (middle_.info() != Eigen::Success) used_.clear();
}

void StepResponses::take_contacts(float* z) const
{
    if (used_.empty()) return;
    const auto m = static_cast<Index>(used_.size());
    Eigen::VectorXd moved(3 * m);
    for (Index a = 0; a < m; ++a) {
        const Used& one = used_[std::size_t(a)];
        moved.segment<3>(3 * a) = one.root.transpose() * at_contact(*one.contact, z);
    }
    const Eigen::VectorXd pushed = middle_.solve(moved);
    std::vector<std::pair<const float*, float>> columns;
    for (Index a = 0; a < m; ++a) {
        const Used& one = used_[std::size_t(a)];
        const Vector3d push = one.root * pushed.segment<3>(3 * a);
        for (std::size_t i = 0; i < 3; ++i) {
            columns.emplace_back((*one.response)[i].data(), float(push[Index(i)]));
        }
    }
    const std::size_t n = linear_at.size();
    geometry::parallel_for(n, 4096, [&](std::size_t begin, std::size_t end) {
        for (const auto& [column, push] : columns) {
            for (std::size_t i = begin; i < end; ++i) z[i] -= push * column[i];
        }
    });
}

}  // namespace physics
