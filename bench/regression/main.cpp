// gudgeon_regression: counts the kernels of Gudgeon under callgrind; see README.md.

#include "kernels.hpp"

int main(int argc, char** argv) {
    using namespace gudgeon::kernels;
    std::vector<counted::Kernel> counted_kernels;
    for (const Kernel& kernel : all_kernels())
        counted_kernels.push_back({kernel.name, [kernel] {
                                       return kernel.prepare({kernel.bodies, 1, true});
                                   }});
    return counted::run(
        argc, argv, counted_kernels,
        {{"eigen", GUDGEON_EIGEN}, {"suitesparse", GUDGEON_SUITESPARSE}, {"sundials", GUDGEON_SUNDIALS}});
}
