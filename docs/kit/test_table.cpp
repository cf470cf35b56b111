// A leapfrog has order 2 on two bodies, read from a table. In the folder of the kit:
// g++ -O2 -o test_table test_table.cpp && ./test_table point_masses/two_bodies_e03.txt
#include <cmath>
#include <fstream>
#include <iostream>
#include <iterator>
#include <vector>

int main(int, char **arguments) {
    std::ifstream file(arguments[1]);  // rows: t, G m, x, y, z, vx, vy, vz and two errors
    std::vector<double> table{std::istream_iterator<double>(file), {}};
    const double *one = table.data(), *other = one + 10, *end = one + table.size() - 20;
    double errors[3], gm = one[1] + other[1], duration = end[0] - one[0];
    for (int k = 0; k < 3; ++k) {
        double q[3], v[3], h = duration / (1000 << k);
        for (int i = 0; i < 3; ++i) q[i] = other[2 + i] - one[2 + i], v[i] = other[5 + i] - one[5 + i];
        for (int n = 0; n < 1000 << k; ++n) {
            for (int i = 0; i < 3; ++i) q[i] += h / 2 * v[i];
            const double r = std::hypot(q[0], q[1], q[2]);
            for (int i = 0; i < 3; ++i) v[i] -= h * gm * q[i] / (r * r * r), q[i] += h / 2 * v[i];
        }
        errors[k] = 0.0;
        for (int i = 0; i < 3; ++i) errors[k] += std::abs(q[i] - (end[12 + i] - end[2 + i]));
    }
    const double orders[] = {std::log2(errors[0] / errors[1]), std::log2(errors[1] / errors[2])};
    std::cout << "orders " << orders[0] << " and " << orders[1] << "\n";
    return !(std::abs(orders[0] - 2) < 0.3 && std::abs(orders[1] - 2) < 0.3);
}
