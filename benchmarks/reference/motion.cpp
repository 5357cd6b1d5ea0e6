// Motions of a disk with friction in long double or quadruple precision, independent of the package.
//
// Newton-Euler in the inertial frame.  State: the axis n, the angular momentum L about the centre, the
// horizontal velocity v of the centre.  With m = R = g = 1 and moments k, k, 2k:
//     n' = L x n / k,   L' = a x F,   v' = F - Z,   vA = v + w x a,   a = (n_z n - Z) / |n_h|.
// The force F follows at every evaluation from d(vA)/dt = C F + b: its vertical part is zero, and the
// horizontal one is the law's.  No angle, no frame that turns, no formula solved by hand.
//
// Integrator: Radau IIA collocation with S stages (order 2S - 1, stiffly accurate), simplified Newton
// (or fixed-point iteration where nothing is stiff); the step follows the last Legendre coefficient of
// the stages.  The nodes and weights are computed in the working precision.
//
// Standard input, one launch a line:
//     law k mu eps flat T stages digits start(6) evaluations      law: smooth viscous linear rough regularised
// Standard output: outcome time state(6) gn D steps   outcome: moving lift-off flat stuck exhausted
//
//     g++ -O2 -std=gnu++17 motion.cpp -o motion -lquadmath           (long double)
//     g++ -O2 -std=gnu++17 -DQUAD motion.cpp -o motion4 -lquadmath   (quadruple)
#include <cmath>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>
#include <quadmath.h>

#ifdef QUAD
typedef __float128 Real;
static Real root(Real x) { return sqrtq(x); }
static Real sine(Real x) { return sinq(x); }
static Real cosine(Real x) { return cosq(x); }
static Real angle(Real y, Real x) { return atan2q(y, x); }
static Real power(Real x, Real y) { return powq(x, y); }
static bool finite_(Real x) { return finiteq(x); }
static const Real EPS = FLT128_EPSILON, PI = M_PIq;
#else
typedef long double Real;
static Real root(Real x) { return sqrtl(x); }
static Real sine(Real x) { return sinl(x); }
static Real cosine(Real x) { return cosl(x); }
static Real angle(Real y, Real x) { return atan2l(y, x); }
static Real power(Real x, Real y) { return powl(x, y); }
static bool finite_(Real x) { return std::isfinite(x); }
static const Real EPS = 1.0842021724855044e-19L, PI = 3.14159265358979323846264338327950288L;
#endif

static std::string text(Real x) {
    char buffer[64];
#ifdef QUAD
    quadmath_snprintf(buffer, sizeof buffer, "%.32Qe", x);
#else
    std::snprintf(buffer, sizeof buffer, "%.20Le", x);
#endif
    return buffer;
}

static Real size(Real x) { return x < 0 ? -x : x; }

struct Vec {
    Real x, y, z;
};
static Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static Vec operator*(Real s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
static Real dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vec cross(Vec a, Vec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

enum Law { SMOOTH, VISCOUS, LINEAR, ROUGH, REGULARISED };
static const int DIM = 8;
typedef std::vector<Real> Row;

struct Disk {
    Law law;
    Real k, mu, eps, flat;

    // dy/dt; the guards gn D and sin(theta) - flat, and gn, D themselves
    void rates(const Real *y, Real *dy, Real *guards) const {
        Vec n{y[0], y[1], y[2]}, L{y[3], y[4], y[5]};
        Real h = root(n.x * n.x + n.y * n.y);
        Vec a{n.z * n.x / h, n.z * n.y / h, -h};
        Real spin = dot(L, n) / (2 * k);
        Vec w = (1 / k) * L - spin * n, dn = (1 / k) * cross(L, n);
        Real dh = (n.x * dn.x + n.y * dn.y) / h;
        Vec da{(dn.z * n.x + n.z * dn.x - a.x * dh) / h, (dn.z * n.y + n.z * dn.y - a.y * dh) / h, -dh};
        Vec turning = cross(w, a);
        Vec slip{y[6] + turning.x, y[7] + turning.y, 0};
        Vec b = cross((-spin) * dn, a) + cross(w, da) - Vec{0, 0, 1};
        auto C = [&](Vec F) {
            Vec torque = cross(a, F);
            return F + cross((1 / k) * torque - (dot(torque, n) / (2 * k)) * n, a);
        };
        Vec F{0, 0, 0};
        Real A = C({0, 0, 1}).z, B = -b.z;
        if (law == ROUGH) {
            Vec c0 = C({1, 0, 0}), c1 = C({0, 1, 0}), c2 = C({0, 0, 1});
            Real whole = dot(c0, cross(c1, c2));
            F = {-dot(b, cross(c1, c2)) / whole, -dot(c0, cross(b, c2)) / whole,
                 -dot(c0, cross(c1, b)) / whole};
            B = F.z * A;
        } else if (law == LINEAR) {
            Vec f = (-mu) * slip;
            B -= C(f).z;
            F = f + Vec{0, 0, B / A};
        } else {
            Vec u{0, 0, 0};
            if (law == VISCOUS) u = mu * slip;
            if (law == REGULARISED)
                u = (mu / root(slip.x * slip.x + slip.y * slip.y + eps * eps)) * slip;
            A -= C(u).z;
            F = (B / A) * (Vec{0, 0, 1} - u);
        }
        Vec dL = cross(a, F);
        dy[0] = dn.x, dy[1] = dn.y, dy[2] = dn.z, dy[3] = dL.x, dy[4] = dL.y, dy[5] = dL.z;
        dy[6] = F.x, dy[7] = F.y;
        if (guards) guards[0] = B * k, guards[1] = h - flat, guards[2] = F.z, guards[3] = A * k;
    }

    void pack(const Real *six, Real *y) const {
        Real s = sine(six[0]), c = cosine(six[0]);
        Vec one{c, 0, -s}, two{0, 1, 0}, n{s, 0, c};
        Vec w = (-six[2] * s) * one + six[1] * two + six[3] * n, turning = cross(w, one);
        Vec L = k * w + (k * six[3]) * n;
        y[0] = n.x, y[1] = n.y, y[2] = n.z, y[3] = L.x, y[4] = L.y, y[5] = L.z;
        y[6] = six[4] - turning.x, y[7] = six[5] - turning.y;
    }

    void unpack(const Real *y, Real *six) const {
        Vec n{y[0], y[1], y[2]}, L{y[3], y[4], y[5]};
        Real h = root(n.x * n.x + n.y * n.y);
        Vec x{n.x / h, n.y / h, 0}, across{-x.y, x.x, 0};
        Vec one = n.z * x - Vec{0, 0, h};
        six[3] = dot(L, n) / (2 * k);
        Vec w = (1 / k) * L - six[3] * n, turning = cross(w, one);
        Vec slip{y[6] + turning.x, y[7] + turning.y, 0};
        six[0] = angle(h, n.z), six[1] = dot(w, across), six[2] = -dot(w, one) / h;
        six[4] = dot(slip, x), six[5] = dot(slip, across);
    }
};

static void legendre(int count, Real x, Real *p) {  // P_0 .. P_{count-1} on [0, 1]
    Real t = 2 * x - 1;
    p[0] = 1;
    if (count > 1) p[1] = t;
    for (int j = 1; j + 1 < count; j++) p[j + 1] = ((2 * j + 1) * t * p[j] - j * p[j - 1]) / (j + 1);
}

template <class T> struct LU {
    int n = 0;
    std::vector<T> a;
    std::vector<int> pivot;
    static T most(T x) { return x < 0 ? -x : x; }
    bool factor(int size_, std::vector<T> &matrix) {
        n = size_, a.swap(matrix), pivot.resize(n);
        for (int i = 0; i < n; i++) {
            int best = i;
            for (int r = i + 1; r < n; r++)
                if (most(a[r * n + i]) > most(a[best * n + i])) best = r;
            pivot[i] = best;
            if (!(most(a[best * n + i]) > 0)) return false;
            if (best != i)
                for (int c = 0; c < n; c++) std::swap(a[i * n + c], a[best * n + c]);
            const T *from = &a[i * n];
            for (int r = i + 1; r < n; r++) {
                T *to = &a[r * n], f = to[i] /= from[i];
                if (f != 0)
                    for (int c = i + 1; c < n; c++) to[c] -= f * from[c];
            }
        }
        return true;
    }
    void solve(std::vector<T> &b) const {
        for (int i = 0; i < n; i++) std::swap(b[i], b[pivot[i]]);
        for (int i = 0; i < n; i++)
            for (int c = 0; c < i; c++) b[i] -= a[i * n + c] * b[c];
        for (int i = n - 1; i >= 0; i--) {
            for (int c = i + 1; c < n; c++) b[i] -= a[i * n + c] * b[c];
            b[i] /= a[i * n + i];
        }
    }
};

struct Radau {
    int s;
    Row c, A, inverse;  // nodes; weights; stage values -> Legendre coefficients
    explicit Radau(int stages) : s(stages), c(s), A(s * s), inverse(s * s) {
        Row p(s + 2);
        for (int i = 0; i < s; i++) {  // roots of P_s - P_{s-1} on [0, 1]; the last is 1
            Real x = (1 - cosine(PI * (2 * i + Real(1.5)) / (2 * s))) / 2;
            for (int turn = 0; turn < 100 && i < s - 1; turn++) {
                auto f = [&](Real at) { legendre(s + 1, at, p.data()); return p[s] - p[s - 1]; };
                Real value = f(x), d = Real(1e-8);
                Real slope = (f(x + d) - f(x - d)) / (2 * d), move = value / slope;
                Real others = 0;  // keep away from the roots already found
                for (int j = 0; j < i; j++) others += 1 / (x - c[j]);
                others += 1 / (x - 1);
                move = value / (slope - value * others);
                x -= move;
                if (size(move) < 2 * EPS) break;
            }
            c[i] = i == s - 1 ? Real(1) : x;
        }
        for (int i = 0; i < s; i++)
            for (int j = i + 1; j < s; j++)
                if (c[j] < c[i]) std::swap(c[i], c[j]);
        Row V(s * s), Q(s * s);
        for (int i = 0; i < s; i++) {
            legendre(s + 1, c[i], p.data());
            for (int j = 0; j < s; j++) {
                V[i * s + j] = p[j];
                Q[i * s + j] = j ? (p[j + 1] - p[j - 1]) / (2 * (2 * j + 1)) : c[i];
            }
        }
        LU<Real> lu;
        lu.factor(s, V);
        for (int j = 0; j < s; j++) {
            Row e(s, 0);
            e[j] = 1;
            lu.solve(e);
            for (int i = 0; i < s; i++) inverse[i * s + j] = e[i];
        }
        for (int i = 0; i < s; i++)
            for (int j = 0; j < s; j++)
                for (int m = 0; m < s; m++) A[i * s + j] += Q[i * s + m] * inverse[m * s + j];
    }
};

struct Run {
    const Disk &disk;
    const Radau &m;
    Real goal;
    long evaluations = 0, budget;
    LU<double> lu;  // of the Newton matrix: it need not be exact
    bool have_guess = false;
    Row guess_k;
    Real guess_h = 0;
    Run(const Disk &d, const Radau &r, Real g, long b) : disk(d), m(r), goal(g), budget(b) {}

    void jacobian(const Real *y, Real *J) {
        Real base[DIM], other[DIM], moved[DIM];
        disk.rates(y, base, nullptr);
        for (int j = 0; j < DIM; j++) {
            for (int i = 0; i < DIM; i++) moved[i] = y[i];
            Real d = root(EPS) * (1 + size(y[j]));
            if (disk.law == REGULARISED) d = (d < disk.eps ? d : disk.eps) * Real(1e-3);
            moved[j] += d;
            disk.rates(moved, other, nullptr);
            for (int i = 0; i < DIM; i++) J[i * DIM + j] = (other[i] - base[i]) / d;
        }
    }

    // One step; K the rates at the stages, Z the stages less y.  False where no convergence.
    bool stages(const Real *y, Real h, Row &K, Row &Z, const Real *J, bool stiff) {
        int s = m.s, n = s * DIM;
        Z.assign(n, 0), K.assign(n, 0);
        Row first(DIM), now(DIM);
        disk.rates(y, first.data(), nullptr);
        for (int i = 0; i < s; i++)
            for (int d = 0; d < DIM; d++) K[i * DIM + d] = first[d];
        if (have_guess) {  // extrapolate the last step's polynomial
            Row p(s), q(s);
            for (int i = 0; i < s; i++) {
                legendre(s, 1 + m.c[i] * h / guess_h, p.data());
                for (int j = 0; j < s; j++) {
                    q[j] = 0;
                    for (int l = 0; l < s; l++) q[j] += p[l] * m.inverse[l * s + j];
                }
                for (int d = 0; d < DIM; d++) {
                    Real v = 0;
                    for (int j = 0; j < s; j++) v += q[j] * guess_k[j * DIM + d];
                    if (h <= guess_h) K[i * DIM + d] = v;
                }
            }
        }
        multiply(h, K, Z);
        if (stiff) {
            std::vector<double> M(n * n, 0.0);
            for (int i = 0; i < s; i++)
                for (int j = 0; j < s; j++)
                    for (int a = 0; a < DIM; a++)
                        for (int b = 0; b < DIM; b++)
                            M[(i * DIM + a) * n + j * DIM + b] =
                                (double)((i == j && a == b ? 1 : 0) - h * m.A[i * s + j] * J[a * DIM + b]);
            if (!lu.factor(n, M)) return false;
        }
        Row W(n), point(DIM);
        Real last = 0, floor_ = 64 * EPS;
        int good = 0;
        for (int turn = 0; turn < (stiff ? 60 : 80); turn++) {
            for (int i = 0; i < s; i++) {
                for (int d = 0; d < DIM; d++) point[d] = y[d] + Z[i * DIM + d];
                disk.rates(point.data(), &K[i * DIM], nullptr);
            }
            evaluations += s;
            multiply(h, K, W);
            Real most = 0;
            for (int i = 0; i < n; i++) W[i] -= Z[i];
            if (stiff) {
                Real unit = 0;  // scaled to 1, so that doubles hold it
                for (int i = 0; i < n; i++) unit = size(W[i]) > unit ? size(W[i]) : unit;
                std::vector<double> w(n);
                if (unit > 0) {
                    for (int i = 0; i < n; i++) w[i] = (double)(W[i] / unit);
                    lu.solve(w);
                    for (int i = 0; i < n; i++) W[i] = unit * w[i];
                }
            }
            for (int i = 0; i < n; i++) {
                Z[i] += W[i];
                Real v = size(W[i]) / (1 + size(y[i % DIM]));
                if (!(v <= most)) most = v;
            }
            if (!finite_(most)) return false;
            if (most < floor_ && ++good >= 2) return true;
            if (turn > 3 && most >= last / 2) return most < 1000 * floor_;
            last = most;
        }
        return false;
    }

    void multiply(Real h, const Row &K, Row &Z) {
        int s = m.s;
        for (int i = 0; i < s; i++)
            for (int d = 0; d < DIM; d++) {
                Real v = 0;
                for (int j = 0; j < s; j++) v += m.A[i * s + j] * K[j * DIM + d];
                Z[i * DIM + d] = h * v;
            }
    }

    // Largest of the last two Legendre coefficients of the rates, times h, over the state's size
    Real tail(const Real *y, Real h, const Row &K) {
        int s = m.s;
        Real most = 0;
        for (int d = 0; d < DIM; d++)
            for (int l = s - 2; l < s; l++) {
                Real v = 0;
                for (int j = 0; j < s; j++) v += m.inverse[l * s + j] * K[j * DIM + d];
                v = size(v) * h / (1 + size(y[d]));
                if (!(v <= most)) most = v;
            }
        return most;
    }

    std::string integrate(const Real *six, Real last, Real &time, Real *end, Real *seen, long &steps) {
        int s = m.s;
        Real y[DIM], J[DIM * DIM];
        disk.pack(six, y);
        time = 0, steps = 0;
        Real h = last < Real(1e-3) ? last : Real(1e-3);
        std::string outcome = "moving";
        Row K, Z;
        Real dy[DIM];
        while (time < last && evaluations < budget) {
            if (time + h > last || last - time - h < h / 1000) h = last - time;
            jacobian(y, J);
            Real norm = 0;
            for (int i = 0; i < DIM * DIM; i++) norm = size(J[i]) > norm ? size(J[i]) : norm;
            bool stiff = norm * h > 1;
            if (steps == 0) have_guess = false;
            bool fine = stages(y, h, K, Z, J, stiff);
            if (!fine) have_guess = false, fine = stages(y, h, K, Z, J, true);
            Real error = fine ? tail(y, h, K) : Real(1e30);
            Real allowed = goal + 50 * EPS * norm * h;  // rounding of the rates
            if (!(error <= allowed)) {
                Real factor = fine ? power(allowed / error, Real(1) / (s - 1)) * Real(0.9) : Real(0.25);
                h *= factor < Real(0.1) ? Real(0.1) : (factor > Real(0.8) ? Real(0.8) : factor);
                have_guess = false;
                if (h < 100 * EPS * (time + Real(1e-6))) { outcome = "stuck"; break; }
                continue;
            }
            // guards at the stages; a sign change shortens the step until its end is the zero
            Real g[4], low = 0, high = 0;
            int which = -1;
            for (int i = 0; i < s && which < 0; i++) {
                Real point[DIM];
                for (int d = 0; d < DIM; d++) point[d] = y[d] + Z[i * DIM + d];
                disk.rates(point, dy, g);
                for (int j : {0, 1, 3})  // gn D stays positive where gn and D change sign together
                    if (!(g[j] > 0)) which = j, low = i ? m.c[i - 1] * h : 0, high = m.c[i] * h;
            }
            if (which >= 0) {
                have_guess = false;
                for (int turn = 0; turn < 200 && high - low > 4 * EPS * (time + high); turn++) {
                    Real middle = (low + high) / 2;
                    if (!(stages(y, middle, K, Z, J, stiff) || stages(y, middle, K, Z, J, true))) {
                        which = 2;  // no convergence: the zero is not known
                        break;
                    }
                    Real point[DIM];
                    for (int d = 0; d < DIM; d++) point[d] = y[d] + Z[(s - 1) * DIM + d];
                    disk.rates(point, dy, g);
                    if (g[which] > 0) low = middle; else high = middle;
                }
                if (!stages(y, high, K, Z, J, stiff)) stages(y, high, K, Z, J, true);
                for (int d = 0; d < DIM; d++) y[d] += Z[(s - 1) * DIM + d];
                time += high;
                disk.rates(y, dy, g);
                outcome = which == 3 ? "stuck" : which == 2 ? "exhausted" : which ? "flat" : "lift-off";
                // gn D and D may vanish together, gn staying positive
                if (which != 1 && size(g[3]) < Real(1e-6)) outcome = "stuck";
                break;
            }
            for (int d = 0; d < DIM; d++) y[d] += Z[(s - 1) * DIM + d];
            time += h, steps++;
            guess_k = K, guess_h = h, have_guess = true;
            Real factor = error > 0 ? power(allowed / error, Real(1) / (s - 1)) * Real(0.9) : Real(3);
            h *= factor > 3 ? Real(3) : factor;
        }
        if (outcome == "moving" && time < last) outcome = "exhausted";
        disk.unpack(y, end);
        disk.rates(y, dy, seen);
        return outcome;
    }
};

static Real number(const std::string &word) {
#ifdef QUAD
    return strtoflt128(word.c_str(), nullptr);
#else
    return strtold(word.c_str(), nullptr);
#endif
}

int main() {
    std::string line;
    int known = 0;
    Radau *method = nullptr;
    while (std::getline(std::cin, line)) {
        std::istringstream in(line);
        std::string law, word;
        std::vector<Real> v;
        in >> law;
        while (in >> word) v.push_back(number(word));
        if (v.size() != 14) { std::cout << "refused" << std::endl; continue; }
        Disk disk{law == "smooth" ? SMOOTH : law == "viscous" ? VISCOUS : law == "linear" ? LINEAR
                  : law == "rough" ? ROUGH : REGULARISED, v[0], v[1], v[2], sine(v[3])};
        int stages = (int)v[5];
        if (stages != known) { delete method; method = new Radau(stages); known = stages; }
        Run run(disk, *method, power(Real(10), -v[6]), (long)v[13]);
        Real time, end[6], seen[4];
        long steps;
        std::string outcome = run.integrate(&v[7], v[4], time, end, seen, steps);
        std::cout << outcome << ' ' << text(time);
        for (int i = 0; i < 6; i++) std::cout << ' ' << text(end[i]);
        std::cout << ' ' << text(seen[2]) << ' ' << text(seen[3]) << ' ' << steps << std::endl;
    }
}
