#include "core/constraints.hpp"

#include "core/motion_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

// A batch with one element between bodies 0 and 1, evaluated on its own.
template <class Kernel> class OneConstraint {
  public:
    static constexpr int R = Kernel::rows;

    OneConstraint(typename Kernel::Element x, int moving) : moving_(moving) {
        x.a = 0;
        x.b = 1;
        x.row = 0;
        batch_.add(std::move(x));
        BlockLayoutBuilder builder(moving);
        batch_.finish(builder);
        layout_ = std::move(builder).finish();
    }

    MatX phi(const Pair& m, double t) const {
        VecX out = VecX::Zero(R);
        ConstraintSink sink;
        sink.phi = out.data();
        batch_.evaluate(at(m, t), sink);
        return out;
    }
    MatX rate(const Pair& m, double t) const {
        VecX out = VecX::Zero(R);
        ConstraintSink sink;
        sink.rate = out.data();
        batch_.evaluate(at(m, t), sink);
        return out;
    }
    MatX rows(const Pair& m, double t) const {
        Rows out = Rows::Zero(R, 12);
        ConstraintSink sink;
        sink.rows = out.data();
        batch_.evaluate(at(m, t), sink);
        return out;
    }
    MatX forces(const Pair& m, double t, const VecX& lambda) const {
        VecX out = VecX::Zero(12);
        ConstraintSink sink;
        sink.lambda = lambda.data();
        sink.f = {out.data(), moving_};
        batch_.evaluate(at(m, t), sink);
        return out;
    }
    MatX acceleration_rhs(const Pair& m, double t) const {
        VecX out = VecX::Zero(R);
        batch_.acceleration_rhs(at(m, t), out.data());
        return out;
    }
    MatX time_rate(const Pair& m, double t) const {
        VecX out = VecX::Zero(R);
        batch_.time_rate(at(m, t), out.data());
        return out;
    }
    MatX rate_gradient(const Pair& m, double t) const {
        Rows out = Rows::Zero(R, 12);
        batch_.rate_gradient(at(m, t), out.data());
        return out;
    }
    // d(G^T lambda)/dq, gathered from the stored blocks.
    Mat12 geometric(const Pair& m, double t, const VecX& lambda) const {
        Linearisation lin;
        lin.S.assign(9 * static_cast<std::size_t>(layout_.blocks()), 0.0);
        lin.pairs = layout_.pairs;
        batch_.add_geometric(at(m, t), lambda.data(), lin);
        Mat12 out = Mat12::Zero();
        for (int i = 0; i < layout_.blocks(); ++i)
            out.block<3, 3>(3 * layout_.block_row[i], 3 * layout_.block_col[i]) =
                Eigen::Map<const Mat3>(lin.S.data() + 9 * i);
        return out;
    }

    double angle = 0.2, angle_rate = 0.1; // accepted at t = 0.1

  private:
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

    Evaluation at(const Pair& m, double t) const {
        Evaluation e;
        e.t = t;
        e.body = m.data();
        e.moving = moving_;
        e.angle = &angle;
        e.angle_rate = &angle_rate;
        e.t_accepted = 0.1;
        return e;
    }

    int moving_;
    ConstraintBatchOf<Kernel> batch_;
    BlockLayout layout_;
};

template <class Kernel> void check(const typename Kernel::Element& x, const Pair& m, std::mt19937& rng) {
    const OneConstraint<Kernel> c(x, 2);
    const double t = 0.3;
    const VecX lambda = random_vector(rng, 30).head(Kernel::rows);
    const Vec12 u = velocities(m);

    const MatX g = c.rows(m, t);
    EXPECT_LT(error(g, jacobian(
                           m, [&](const Pair& k) { return c.phi(k, t); }, moved)),
              1e-9);
    EXPECT_LT(error(c.forces(m, t, lambda), -g.transpose() * lambda), 1e-14);
    EXPECT_LT(error(c.time_rate(m, t), derivative([&](double h) { return c.phi(m, t + h); })), 1e-9);

    // Along a motion without accelerations: Phi' = G u + Phi_t, Phi'' = -gamma.
    const auto along = [&](double h) { return c.phi(advanced(m, h), t + h); };
    EXPECT_LT(error(c.rate(m, t), derivative(along, 2e-3)), 1e-9);
    EXPECT_LT(error(c.acceleration_rhs(m, t), -second_derivative(along, 4e-3)), 1e-7);

    const auto gu = [&](const Pair& k) { return MatX(c.rows(k, t) * u); };
    EXPECT_LT(error(c.rate_gradient(m, t), jacobian(m, gu, moved)), 1e-9);
    const auto gt_lambda = [&](const Pair& k) { return MatX(c.rows(k, t).transpose() * lambda); };
    EXPECT_LT(error(c.geometric(m, t, lambda), jacobian(m, gt_lambda, moved)), 1e-9);
}

template <class Kernel> void check_points(typename Kernel::Element& x, std::mt19937& rng) {
    x.sa = random_vector(rng);
    x.sb = random_vector(rng);
    check<Kernel>(x, random_pair(rng), rng);
}

TEST(Constraints, Coincident) {
    std::mt19937 rng(11);
    CoincidentKernel::Element x;
    check_points<CoincidentKernel>(x, rng);
}

TEST(Constraints, Displacement) {
    std::mt19937 rng(12);
    DisplacementKernel::Element x;
    x.x = random_vector(rng);
    check_points<DisplacementKernel>(x, rng);
}

TEST(Constraints, DrivenDisplacement) {
    std::mt19937 rng(13);
    DrivenDisplacementKernel::Element x;
    x.x = random_vector(rng);
    x.function = SmoothStepFunction{0, 1, -0.5, 2};
    check_points<DrivenDisplacementKernel>(x, rng);
}

TEST(Constraints, Alignment) {
    std::mt19937 rng(14);
    AlignmentKernel::Element x;
    x.x = random_vector(rng);
    x.y = random_vector(rng);
    check<AlignmentKernel>(x, random_pair(rng), rng);
}

TEST(Constraints, Distance) {
    std::mt19937 rng(15);
    DistanceKernel::Element x;
    x.length = 1.5;
    check_points<DistanceKernel>(x, rng);
}

TEST(Constraints, DrivenAngle) {
    std::mt19937 rng(16);
    DrivenAngleKernel::Element x;
    x.angle = 0;
    x.function = HarmonicFunction{0.7, 0.5, 0.2, 0.1};
    const Mat3 triad = joint_triad(random_vector(rng));
    x.frames = {triad.col(1), triad.col(0), triad.col(0), triad.col(0)};
    Pair m = random_pair(rng);
    m[1].p = turned(turned(m[0].p, 0.4 * triad.col(2)), 0.1 * triad.col(0));
    m[1].A = rotation(m[1].p);
    check<DrivenAngleKernel>(x, m, rng);
}

// Hand values: a crank turned by 0.5 against a drive that asks for 0.2 + 0.3 (t - 0) at t = 0.3.
TEST(Constraints, DriveIsMeasureMinusFunction) {
    DrivenAngleKernel::Element x;
    x.angle = 0;
    x.frames = {Vec3::UnitY(), Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitX()};
    x.function = RampFunction{0.2, 0.3, 0};
    Pair m;
    m[1].p = turned(m[1].p, Vec3(0, 0, 0.5));
    m[1].A = rotation(m[1].p);
    m[1].w = {0, 0, 2};
    const OneConstraint<DrivenAngleKernel> c(x, 2);
    EXPECT_NEAR(c.phi(m, 0.3)(0), 0.5 - 0.29, 1e-15);
    EXPECT_NEAR(c.rate(m, 0.3)(0), 1.7, 1e-15);
    EXPECT_NEAR(c.time_rate(m, 0.3)(0), -0.3, 1e-15);
    // A positive multiplier pushes b back.
    EXPECT_NEAR(c.forces(m, 0.3, VecX::Constant(1, 4))(11), -4, 1e-15);
}

TEST(Constraints, ResidualsByHand) {
    Pair m;
    m[0].r = {1, 0, 0};
    m[1].r = {1, 3, 4};
    DistanceKernel::Element rod;
    rod.sa = rod.sb = Vec3::Zero();
    rod.length = 4.5;
    EXPECT_NEAR(OneConstraint<DistanceKernel>(rod, 2).phi(m, 0)(0), 0.5, 1e-15);
    DrivenDisplacementKernel::Element slide;
    slide.sa = slide.sb = Vec3::Zero();
    slide.x = Vec3::UnitZ();
    slide.function = ConstantFunction{1.5};
    EXPECT_NEAR(OneConstraint<DrivenDisplacementKernel>(slide, 2).phi(m, 0)(0), 2.5, 1e-15);
    CoincidentKernel::Element pin;
    pin.sa = {0, 1, 0};
    pin.sb = {0, 0, -4};
    EXPECT_LT((OneConstraint<CoincidentKernel>(pin, 2).phi(m, 0) - Vec3(0, 2, 0)).norm(), 1e-15);
}

TEST(Constraints, FixedBodiesReceiveNothing) {
    std::mt19937 rng(17);
    CoincidentKernel::Element x;
    x.sa = random_vector(rng);
    x.sb = random_vector(rng);
    const OneConstraint<CoincidentKernel> c(x, 1); // body 1 is fixed
    const VecX lambda = random_vector(rng);
    const MatX f = c.forces(random_pair(rng), 0, lambda);
    EXPECT_EQ(f.bottomRows(6).norm(), 0);
    EXPECT_GT(f.topRows(6).norm(), 0.1);
}

// A point pinned at distance 2 from a centre with angular velocity 3: centripetal 18 m/s2.
TEST(Constraints, CentripetalAcceleration) {
    CoincidentKernel::Element x;
    x.sa = {2, 0, 0};
    x.sb = Vec3::Zero();
    Pair m;
    m[0].w = {0, 0, 3};
    m[1].r = {2, 0, 0};
    m[1].v = {0, 6, 0};
    const OneConstraint<CoincidentKernel> c(x, 2);
    EXPECT_LT(c.phi(m, 0).norm(), 1e-15);
    EXPECT_LT(c.rate(m, 0).norm(), 1e-15);
    // r_b'' + ... = gamma with the bodies' own accelerations zero but r_b'': -18 along x
    EXPECT_LT((c.acceleration_rhs(m, 0) - Vec3(-18, 0, 0)).norm(), 1e-14);
}

struct Link {
    int a, b, number;
};

TEST(Colouring, NoTwoOfAColourShareAMovingBody) {
    std::mt19937 rng(18);
    const int bodies = 60, moving = 50;
    std::uniform_int_distribution<int> any(0, bodies - 1);
    ColouredElements<Link> links;
    const int count = 400;
    for (int i = 0; i < count; ++i)
        links.items().push_back({any(rng), any(rng), i});
    links.colour(moving);

    const auto starts = links.colour_starts();
    ASSERT_EQ(starts.front(), 0);
    ASSERT_EQ(starts.back(), count);
    std::vector<bool> seen(count, false);
    for (std::size_t c = 0; c + 1 < starts.size(); ++c) {
        std::vector<int> user(moving, -1);
        int last = -1;
        for (int i = starts[c]; i < starts[c + 1]; ++i) {
            const Link& link = links.items()[i];
            for (const int body : {link.a, link.b}) {
                if (body >= moving)
                    continue;
                EXPECT_TRUE(user[body] == -1 || user[body] == i) << "body " << body << " colour " << c;
                user[body] = i;
            }
            EXPECT_GT(link.number, last); // input order inside a colour
            last = link.number;
            EXPECT_FALSE(seen[link.number]);
            seen[link.number] = true;
        }
    }
}

TEST(Colouring, AChainNeedsTwoColours) {
    ColouredElements<Link> links;
    for (int i = 0; i < 100; ++i)
        links.items().push_back({i, i + 1, i});
    links.colour(101);
    EXPECT_EQ(links.colour_starts().size(), 3u);
}

} // namespace
} // namespace gudgeon
