// gudgeon_regression: counts the kernels of Gudgeon under callgrind; see README.md.

#include "kernels.hpp"

int main(int argc, char** argv) {
    using namespace gudgeon::regression;
    Kernels kernels;
    for (const auto group : {joint_kernels, contact_kernels, law_kernels, system_kernels, step_kernels})
        for (counted::Kernel& kernel : group())
            kernels.push_back(std::move(kernel));
    return counted::run(
        argc, argv, kernels,
        {{"eigen", GUDGEON_EIGEN}, {"suitesparse", GUDGEON_SUITESPARSE}, {"sundials", GUDGEON_SUNDIALS}});
}
