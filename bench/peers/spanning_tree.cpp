#include "bench/peers/spanning_tree.hpp"

#include <algorithm>
#include <queue>
#include <unordered_map>

namespace gudgeon::peers {

namespace {

[[noreturn]] void refuse(const Model& model, const std::string& list, std::size_t index,
                         const std::string& problem, const std::string& allowed) {
    throw ModelError(model.source, "/" + list + "/" + std::to_string(index), problem, allowed);
}

bool is_plain(const Bushing& bushing) {
    return std::all_of(bushing.tables.begin(), bushing.tables.end(),
                       [](const Table& t) { return t.empty(); });
}

void refuse_joint(const Model& model, std::size_t i) {
    const Joint& joint = model.joints[i];
    const auto no = [&](const std::string& problem, const std::string& allowed) {
        refuse(model, "joints", i, "joint " + joint.name + ": " + problem + " not known to this program",
               allowed);
    };
    const bool mixed = std::any_of(joint.motions.begin(), joint.motions.end(),
                                   [](const auto& motion) { return motion.has_value(); });
    if (joint.body_frame)
        no("points in body frames are", "global points");
    if (mixed || joint.fidelity == Fidelity::clearance || joint.fidelity == Fidelity::free)
        no("this fidelity is", "perfect or bushing for the whole joint");
    if (!joint.stops.empty() || !joint.friction.empty() || !joint.drives.empty())
        no("stops, friction and drives are", "joints without them");
    if (joint.fidelity == Fidelity::bushing) {
        if (!is_plain(*joint.bushing))
            no("tables of bushings are", "stiffness and damping");
        return;
    }
    if (joint.kind != JointKind::revolute && joint.kind != JointKind::spherical &&
        joint.kind != JointKind::rigid && joint.kind != JointKind::distance)
        no("this kind is", "revolute, spherical, rigid, distance; any kind as bushing");
}

struct ForceCheck {
    const Model& model;
    std::size_t index;

    void operator()(const SpringDamper& f) const {
        if (f.body_frame || f.preload || !f.table.empty() || f.actuator)
            no(f.name, "stiffness, damping and free_length, global points");
    }
    void operator()(const Tyre& f) const {
        if (f.body_frame || !f.profile.empty())
            no(f.name, "stiffness, damping, preload, reference, road, global point");
    }
    void operator()(const TorsionSpring& f) const { no(f.name, "spring-damper, tyre"); }
    void operator()(const AppliedForce& f) const { no(f.name, "spring-damper, tyre"); }
    void operator()(const FrictionForce& f) const { no(f.name, "spring-damper, tyre"); }
    void no(const std::string& name, const std::string& allowed) const {
        refuse(model, "forces", index, "force " + name + " is not known to this program", allowed);
    }
};

// A joint that may carry a body.
bool carries(const Joint& joint) {
    return joint.fidelity == Fidelity::perfect && joint.kind != JointKind::distance;
}

struct Graph {
    struct Edge {
        int to, joint;
    };
    std::vector<std::vector<Edge>> edges; // by body + 1, the ground first
};

Graph graph_of(const Model& model) {
    std::unordered_map<std::string, int> index{{"ground", ground}};
    for (std::size_t i = 0; i < model.bodies.size(); ++i)
        index[model.bodies[i].name] = static_cast<int>(i);
    Graph graph;
    graph.edges.resize(model.bodies.size() + 1);
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
        const Joint& joint = model.joints[j];
        if (!carries(joint))
            continue;
        const int a = index.at(joint.bodies[0]), b = index.at(joint.bodies[1]);
        graph.edges[a + 1].push_back({b, static_cast<int>(j)});
        graph.edges[b + 1].push_back({a, static_cast<int>(j)});
    }
    return graph;
}

class Builder {
  public:
    explicit Builder(const Model& model)
        : model_(model), graph_(graph_of(model)), place_(model.bodies.size(), -1),
          used_(model.joints.size(), false) {}

    SpanningTree build() {
        grow(ground);
        std::vector<int> roots(model_.bodies.size());
        for (std::size_t i = 0; i < roots.size(); ++i)
            roots[i] = static_cast<int>(i);
        std::stable_sort(roots.begin(), roots.end(), [&](int a, int b) {
            return graph_.edges[a + 1].size() > graph_.edges[b + 1].size();
        });
        for (const int root : roots)
            if (place_[root] < 0) {
                add({root, ground, -1});
                grow(root);
            }
        for (std::size_t j = 0; j < model_.joints.size(); ++j)
            if (!used_[j] && model_.joints[j].fidelity == Fidelity::perfect) {
                tree_.loops.push_back(static_cast<int>(j));
                tree_.planar.push_back(is_planar(model_.joints[j]));
            }
        return std::move(tree_);
    }

  private:
    void add(const TreeBody& body) {
        place_[body.body] = static_cast<int>(tree_.bodies.size());
        tree_.bodies.push_back(body);
    }

    void grow(int root) {
        std::queue<int> front;
        front.push(root);
        for (; !front.empty(); front.pop())
            for (const Graph::Edge& edge : graph_.edges[front.front() + 1])
                if (edge.to != ground && place_[edge.to] < 0) {
                    add({edge.to, front.front(), edge.joint});
                    used_[edge.joint] = true;
                    front.push(edge.to);
                }
    }

    // Walks from both sides of the loop's joint to where they meet.
    bool is_planar(const Joint& loop) const {
        if (loop.kind != JointKind::revolute)
            return false;
        int a = body_index(model_, loop.bodies[0]), b = body_index(model_, loop.bodies[1]);
        while (a != b) {
            int& outer = (a == ground ? -1 : place_[a]) > (b == ground ? -1 : place_[b]) ? a : b;
            const TreeBody& at = tree_.bodies[place_[outer]];
            if (at.joint < 0 || !is_parallel(model_.joints[at.joint], loop))
                return false;
            outer = at.inboard;
        }
        return true;
    }

    static bool is_parallel(const Joint& joint, const Joint& loop) {
        if (joint.kind == JointKind::rigid)
            return true;
        return joint.kind == JointKind::revolute &&
               (*joint.axes)[0].normalized().cross((*loop.axes)[0].normalized()).norm() < 1e-12;
    }

    const Model& model_;
    Graph graph_;
    std::vector<int> place_; // of a body in the tree
    std::vector<bool> used_;
    SpanningTree tree_;
};

} // namespace

int body_index(const Model& model, const std::string& name) {
    if (name == "ground")
        return ground;
    const auto found =
        std::find_if(model.bodies.begin(), model.bodies.end(), [&](const Body& b) { return b.name == name; });
    return static_cast<int>(found - model.bodies.begin());
}

void refuse_unknown(const Model& model) {
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
        const Body& body = model.bodies[i];
        if (body.fixed || body.start_position || body.start_orientation)
            refuse(model, "bodies", i, "body " + body.name + " is fixed or starts elsewhere than given",
                   "moving bodies that start in the pose as given");
    }
    for (std::size_t i = 0; i < model.joints.size(); ++i)
        refuse_joint(model, i);
    for (std::size_t i = 0; i < model.forces.size(); ++i)
        std::visit(ForceCheck{model, i}, model.forces[i]);
    for (std::size_t i = 0; i < model.markers.size(); ++i)
        if (model.markers[i].body_frame)
            refuse(model, "markers", i, "marker " + model.markers[i].name + " has a point in the body frame",
                   "global points");
}

SpanningTree spanning_tree(const Model& model) { return Builder(model).build(); }

} // namespace gudgeon::peers
