// A leapfrog integrator converges with order 2 on two bodies. In the folder of the kit:
// g++ -std=c++17 -o test_table tests/test_table.cpp
// ./test_table point_masses/two_bodies_e03.txt
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <iterator>
#include <vector>

using Vector = std::array<double, 3>;

struct Row {
    double t;
    double gm;
    Vector position;
    Vector velocity;
    double position_error;
    double velocity_error;
};

std::istream& operator>>(std::istream& in, Row& row) {
    in >> row.t >> row.gm;
    for (double& x : row.position) in >> x;
    for (double& x : row.velocity) in >> x;
    return in >> row.position_error >> row.velocity_error;
}

Vector operator-(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

void add(Vector& sum, double factor, const Vector& term) {
    for (int axis = 0; axis < 3; ++axis) sum[axis] += factor * term[axis];
}

double length(const Vector& a) { return std::hypot(a[0], a[1], a[2]); }

// The position of the second body relative to the first after equal steps.
Vector leapfrog(const Row& first, const Row& second, double step, int count) {
    Vector position = second.position - first.position;
    Vector velocity = second.velocity - first.velocity;
    const double gm = first.gm + second.gm;
    for (int k = 0; k < count; ++k) {
        add(position, step / 2, velocity);
        add(velocity, -step * gm / std::pow(length(position), 3), position);
        add(position, step / 2, velocity);
    }
    return position;
}

int main(int argc, char** argv) {
    if (argc != 2) {
        std::cerr << "usage: test_table point_masses/two_bodies_e03.txt\n";
        return 2;
    }
    std::ifstream file(argv[1]);
    const std::vector<Row> rows{std::istream_iterator<Row>(file), {}};  // two for each time
    if (rows.size() < 4) {
        std::cerr << "cannot read " << argv[1] << "\n";
        return 2;
    }
    const Row* end = &rows[rows.size() - 2];
    const Vector truth = end[1].position - end[0].position;
    std::array<double, 3> errors;
    for (int k = 0; k < 3; ++k) {
        const int count = 1000 << k;
        const double step = (end->t - rows[0].t) / count;
        errors[k] = length(leapfrog(rows[0], rows[1], step, count) - truth);
    }
    bool passed = true;
    for (int k = 0; k < 2; ++k) {
        const double order = std::log2(errors[k] / errors[k + 1]);
        std::cout << "order " << order << "\n";
        passed = passed && std::abs(order - 2) < 0.3;
    }
    return passed ? 0 : 1;
}
