#include "core/spanning_tree.hpp"

#include "core/joint_motions.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <queue>
#include <tuple>

namespace gudgeon {

namespace {

std::optional<TreeKind> tree_kind(const Joint& joint) {
    if (joint.cut || !is_wholly_perfect(joint))
        return std::nullopt;
    switch (joint.kind) {
    case JointKind::rigid:
        return TreeKind::rigid;
    case JointKind::revolute:
        return TreeKind::revolute;
    case JointKind::translation:
        return TreeKind::translation;
    case JointKind::cylindrical:
        return TreeKind::cylindrical;
    case JointKind::universal:
        return TreeKind::universal;
    case JointKind::spherical:
        return TreeKind::spherical;
    case JointKind::planar:
        return TreeKind::planar;
    case JointKind::point_on_axis:
    case JointKind::distance:
        break;
    }
    return std::nullopt;
}

// Grows the tree breadth first.
class Grower {
  public:
    explicit Grower(const System& system) : system_(system), link_(system.moving), joints_at_(system.moving) {
        for (std::size_t j = 0; j < system.joints.size(); ++j) {
            kind_.push_back(tree_kind(system.model.joints[j]));
            for (const int body : {system.joints[j].a.body, system.joints[j].b.body})
                if (kind_.back() && body < system.moving)
                    joints_at_[body].push_back(static_cast<int>(j));
        }
    }

    /// By body.
    std::vector<TreeLink> grow() {
        for (std::size_t j = 0; j < system_.joints.size(); ++j) {
            const auto [a, b] = bodies(static_cast<int>(j));
            if (kind_[j] && (a >= system_.moving || b >= system_.moving))
                offer(static_cast<int>(j), 1);
        }
        reach_all();
        std::vector<int> heaviest(system_.moving);
        std::iota(heaviest.begin(), heaviest.end(), 0);
        std::ranges::stable_sort(heaviest, std::greater{}, [&](int i) { return system_.mass[i]; });
        for (const int body : heaviest)
            if (!link_[body]) {
                attach(body, static_cast<int>(system_.body_names.size()) - 1, -1, 1);
                reach_all();
            }
        std::vector<TreeLink> out;
        for (const auto& link : link_)
            out.push_back(*link);
        return out;
    }

  private:
    using Offer = std::tuple<int, int, int>; // depth, speeds, joint

    std::pair<int, int> bodies(int joint) const {
        return {system_.joints[joint].a.body, system_.joints[joint].b.body};
    }
    void offer(int joint, int depth) { offers_.emplace(depth, speed_count(*kind_[joint]), joint); }
    bool reached(int body) const { return body >= system_.moving || link_[body]; }

    void attach(int body, int parent, int joint, int depth) {
        TreeLink link;
        link.body = body;
        link.parent = parent;
        link.joint = joint;
        link.depth = depth;
        if (joint >= 0) {
            link.kind = *kind_[joint];
            link.swapped = system_.joints[joint].a.body == body;
        }
        link_[body] = link;
        for (const int next : joints_at_[body])
            offer(next, depth + 1);
    }

    void reach_all() {
        while (!offers_.empty()) {
            const auto [depth, speeds, joint] = offers_.top();
            offers_.pop();
            const auto [a, b] = bodies(joint);
            if (reached(a) && !reached(b))
                attach(b, a, joint, depth);
            else if (reached(b) && !reached(a))
                attach(a, b, joint, depth);
        }
    }

    const System& system_;
    std::vector<std::optional<TreeLink>> link_;
    std::vector<std::vector<int>> joints_at_;
    std::vector<std::optional<TreeKind>> kind_;
    std::priority_queue<Offer, std::vector<Offer>, std::greater<>> offers_;
};

// Links by body -> parents first, each branch in one piece, so that neighbours lie close in memory.
void number_links(const std::vector<TreeLink>& by_body, SpanningTree& tree) {
    const int n = static_cast<int>(by_body.size());
    std::vector<std::vector<int>> children(n);
    std::vector<int> open;
    for (int i = n - 1; i >= 0; --i)
        if (by_body[i].parent < n)
            children[by_body[i].parent].push_back(i);
        else
            open.push_back(i);
    tree.link_of.assign(n, -1);
    while (!open.empty()) {
        const int body = open.back();
        open.pop_back();
        TreeLink link = by_body[body];
        link.parent_link = link.parent < n ? tree.link_of[link.parent] : -1;
        link.coordinate = tree.coordinates;
        link.speed = tree.speeds;
        tree.coordinates += coordinate_count(link.kind);
        tree.speeds += speed_count(link.kind);
        tree.depth = std::max(tree.depth, link.depth);
        tree.link_of[body] = static_cast<int>(tree.links.size());
        tree.links.push_back(link);
        open.insert(open.end(), children[body].begin(), children[body].end());
    }
}

} // namespace

int SpanningTree::tree_joints() const {
    return static_cast<int>(std::ranges::count_if(links, [](const TreeLink& x) { return x.joint >= 0; }));
}

SpanningTree spanning_tree(const System& system) {
    SpanningTree tree;
    number_links(Grower(system).grow(), tree);
    tree.kept.assign(system.rows.size(), false);
    for (const TreeLink& link : tree.links)
        if (link.joint >= 0) // rows of drives follow those of the joint
            std::fill_n(tree.kept.begin() + system.joints[link.joint].first_row, 6 - speed_count(link.kind),
                        true);
    for (std::size_t j = 0; j < system.joints.size(); ++j) {
        const JointRecord& joint = system.joints[j];
        const auto first = tree.kept.begin() + joint.first_row;
        const int cut = joint.rows - static_cast<int>(std::count(first, first + joint.rows, true));
        tree.cut_rows += cut;
        if (cut > 0)
            tree.cut_joints.push_back(static_cast<int>(j));
    }
    return tree;
}

} // namespace gudgeon
