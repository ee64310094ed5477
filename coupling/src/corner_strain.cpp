#include "defe/coupling/corner_strain.h"

#include "corner_metric.h"
#include "selective_shear.h"

#include "defe/simd.h"
#include "defe/triples.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace defe {

namespace {

  /// lambda_e by number of joints at a corner.
  struct Laws {
    double lambda[4];
    double mu;

    explicit Laws(const CornerModuli &m) : mu(m.mu)
    {
      for (int k = 0; k < 4; ++k) lambda[k] = reduced_lambda(m, k);
    }
  };

}    // namespace

double reduced_lambda(const CornerModuli &m, int joints)
{
  switch (joints) {
    case 3:
      return m.lambda;
    case 2:
      return 2.0 * m.lambda * m.mu / (m.lambda + 2.0 * m.mu);
    case 1:
      return m.mu * (3.0 * m.lambda + 2.0 * m.mu) / (m.lambda + m.mu) - 2.0 * m.mu;
    default:
      return 0.0;
  }
}

// --- any hexahedron ---------------------------------------------------------

namespace {

  // order xx yy zz xy xz yz of what the corners have; index: corner
  constexpr int C = 8;
  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};

  struct Pairs {
    int slot[CornerTable::pairs][2];    // the lower one first
    int of[6][6];
    int at[6][C];    // of a component at a corner
  };

  constexpr Pairs find_pairs()
  {
    Pairs p{};
    for (int s = 0; s < 6; ++s) {
      p.slot[s][0] = p.slot[s][1] = s;
      p.of[s][s] = s;
    }
    int n = 6;
    for (int s = 0; s < 6; ++s)
      for (int t = 2 * (s / 2) + 2; t < 6; ++t) {
        p.slot[n][0] = s;
        p.slot[n][1] = t;
        p.of[s][t] = n++;
      }
    for (int j = 0; j < 6; ++j)
      for (int c = 0; c < C; ++c)
        p.at[j][c] = p.of[corner_slot(c, row[j])][corner_slot(c, column[j])];
    return p;
  }

  constexpr Pairs pair = find_pairs();

}    // namespace

// Absent joints: unit metric, no strain, no vector. The inverse of the rest is then that of the metric of the plane or line of
// the joints that are left (see CornerMetric), and the absent ones' stress multiplies zero.
CornerTable::CornerTable(const GeneralCell &cell, unsigned joints, const CornerModuli &moduli) :
    present(joints)
{
  double metric[pairs];
  for (int p = 0; p < pairs; ++p) {
    const int s = pair.slot[p][0], t = pair.slot[p][1];
    const bool both = present >> s & present >> t & 1u;
    metric[p] = both ? cell.dX[s].dot(cell.dX[t]) : (s == t ? 1.0 : 0.0);
  }
  const Laws laws(moduli);
  double G[6][C];
  for (int c = 0; c < C; ++c) {
    for (int j = 0; j < 6; ++j) G[j][c] = metric[pair.at[j][c]];
    int there = 0;
    for (int a = 0; a < 3; ++a) there += present >> corner_slot(c, a) & 1u;
    lambda[c] = laws.lambda[there];
    volume[c] = corner_volume(cell, c);
  }
  for (int c = 0; c < C; ++c) {
    const double xx = G[0][c], yy = G[1][c], zz = G[2][c], xy = G[3][c], xz = G[4][c], yz = G[5][c];
    const double cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
    const double f = 1.0 / (xx * cxx + xy * cxy + xz * cxz);
    inverse[0][c] = f * cxx;
    inverse[1][c] = f * (xx * zz - xz * xz);
    inverse[2][c] = f * (xx * yy - xy * xy);
    inverse[3][c] = f * cxy;
    inverse[4][c] = f * cxz;
    inverse[5][c] = f * (xy * xz - xx * yz);
  }

  const SelectiveShear selective(cell);
  if (!selective.any()) return;
  ShearTerm list[3];
  terms = selective.terms(cell, present, moduli, inverse, volume, list);
  for (int k = 0; k < terms; ++k) {
    scale[k] = list[k].scale;
    std::fill_n(shear[k], pairs, 0.0);
    for (int j = 0; j < 6; ++j)
      for (int c = 0; c < C; ++c) shear[k][pair.at[j][c]] += list[k].S[j][c];
  }
}

double corner_strain_general(const GeneralCell &cell, const Vec3 y[6], unsigned present,
                             const CornerModuli &moduli, Vec3 half_force[6])
{
  return corner_strain_general(cell, CornerTable(cell, present, moduli), y, moduli, half_force);
}

// The eight corners side by side.
double corner_strain_general(const GeneralCell &cell, const CornerTable &table, const Vec3 y[6],
                             const CornerModuli &moduli, Vec3 half_force[6])
{
  const double mu = moduli.mu;
  constexpr int pairs = CornerTable::pairs;

  // Green strain E_ab = (y_a.y_b - M_a.M_b)/2 of all pairs, by displacements so that nothing cancels when it is small.
  Vec3 current[6], moved[6], both[6];
  for (int s = 0; s < 6; ++s) {
    const Vec3 &M = cell.dX[s];
    const bool there = table.present >> s & 1u;
    current[s] = there ? y[s] : Vec3(Vec3::Zero());
    moved[s] = there ? y[s] - M : Vec3(Vec3::Zero());
    both[s] = there ? y[s] + M : Vec3(Vec3::Zero());
  }
  double strain[pairs], sum[pairs] = {};    // S^ab times volume, summed over the corners
  for (int p = 0; p < pairs; ++p) {
    const int s = pair.slot[p][0], t = pair.slot[p][1];
    strain[p] = 0.25 * (moved[s].dot(both[t]) + moved[t].dot(both[s]));
  }
  double total = 0.0;
  for (int k = 0; k < table.terms; ++k) {
    double normal = 0.0, shear = 0.0;
    for (int p = 0; p < 6; ++p) normal += table.shear[k][p] * strain[p];
    for (int p = 6; p < pairs; ++p) shear += table.shear[k][p] * strain[p];
    const double all = normal + 2.0 * shear, e = table.scale[k] * all;
    total -= 0.5 * e * all;
    for (int p = 0; p < pairs; ++p) sum[p] -= e * table.shear[k][p];
  }

  double E[6][C], S[6][C], energy[C];
  for (int j = 0; j < 6; ++j)
    for (int c = 0; c < C; ++c) E[j][c] = strain[pair.at[j][c]];
  for (int c = 0; c < C; ++c) {
    const double gxx = table.inverse[0][c], gyy = table.inverse[1][c], gzz = table.inverse[2][c];
    const double gxy = table.inverse[3][c], gxz = table.inverse[4][c], gyz = table.inverse[5][c];

    // mixed components G^ac E_cb, then S^ab = lambda_e G^ab tr E + 2 mu G^ac E_cd G^db
    const double exx = E[0][c], eyy = E[1][c], ezz = E[2][c], exy = E[3][c], exz = E[4][c];
    const double eyz = E[5][c];
    const double axx = gxx * exx + gxy * exy + gxz * exz;
    const double axy = gxx * exy + gxy * eyy + gxz * eyz;
    const double axz = gxx * exz + gxy * eyz + gxz * ezz;
    const double ayx = gxy * exx + gyy * exy + gyz * exz;
    const double ayy = gxy * exy + gyy * eyy + gyz * eyz;
    const double ayz = gxy * exz + gyy * eyz + gyz * ezz;
    const double azx = gxz * exx + gyz * exy + gzz * exz;
    const double azy = gxz * exy + gyz * eyy + gzz * eyz;
    const double azz = gxz * exz + gyz * eyz + gzz * ezz;
    const double trace = axx + ayy + azz, w = table.volume[c];
    const double p = w * table.lambda[c] * trace, q = 2.0 * mu * w;
    S[0][c] = p * gxx + q * (axx * gxx + axy * gxy + axz * gxz);
    S[1][c] = p * gyy + q * (ayx * gxy + ayy * gyy + ayz * gyz);
    S[2][c] = p * gzz + q * (azx * gxz + azy * gyz + azz * gzz);
    S[3][c] = p * gxy + q * (axx * gxy + axy * gyy + axz * gyz);
    S[4][c] = p * gxz + q * (axx * gxz + axy * gyz + axz * gzz);
    S[5][c] = p * gyz + q * (ayx * gxz + ayy * gyz + ayz * gzz);
    energy[c] = 0.5 * p * trace +
        0.5 * q * (axx * axx + ayy * ayy + azz * azz + 2.0 * (axy * ayx + axz * azx + ayz * azy));
  }
  for (double e : energy) total += e;

  // f_a = w sum_b S^ab y_b, summed over the corners
  for (int c = 0; c < C; ++c)
    for (int j = 0; j < 6; ++j) sum[pair.at[j][c]] += S[j][c];
  for (int s = 0; s < 6; ++s) half_force[s] = sum[s] * current[s];
  for (int p = 6; p < pairs; ++p) {
    const int s = pair.slot[p][0], t = pair.slot[p][1];
    half_force[s] += sum[p] * current[t];
    half_force[t] += sum[p] * current[s];
  }
  return total;
}

void corner_areas(const GeneralCell &cell, unsigned present, Vec3 half_area[6])
{
  for (int s = 0; s < 6; ++s) half_area[s].setZero();
  for (int corner = 0; corner < 8; ++corner) {
    const CornerMetric m(cell, present, corner);
    const double w = corner_volume(cell, corner);
    for (int a = 0; a < m.joints; ++a)
      for (int b = 0; b < m.joints; ++b)
        half_area[m.slot[a]] += w * m.inverse(a, b) * cell.dX[m.slot[b]];
  }
}

GeneralCell stress_free_cell(const GeneralCell &placed, const Mat3 &map)
{
  GeneralCell cell = placed;
  for (int s = 0; s < 6; ++s) {
    cell.dX[s] = map * placed.dX[s];
    cell.face[s] = map * placed.face[s];
  }
  return cell;
}

bool is_orthogonal(const GeneralCell &cell, double tol)
{
  double limit_dX[6], limit_face[6];    // squared
  for (int s = 0; s < 6; ++s) {
    limit_dX[s] = tol * cell.dX[s].squaredNorm();
    limit_face[s] = tol * cell.face[s].squaredNorm();
  }
  const auto oblique = [](const Vec3 &a, const Vec3 &b, double limit_a, double limit_b) {
    const double dot = a.dot(b);
    return dot * dot > limit_a * limit_b;
  };
  for (int s = 0; s < 6; ++s)
    for (int t = 2 * (s / 2) + 2; t < 6; ++t)
      if (oblique(cell.dX[s], cell.dX[t], limit_dX[s], limit_dX[t]) ||
          oblique(cell.face[s], cell.face[t], limit_face[s], limit_face[t]) ||
          oblique(cell.dX[s], cell.face[t], limit_dX[s], limit_face[t]) ||
          oblique(cell.face[s], cell.dX[t], limit_face[s], limit_dX[t]))
        return false;
  return true;
}

// --- boxes ------------------------------------------------------------------

namespace {

  constexpr int W = LatticeRow::size;    // DEs side by side: one AVX-512 register, two AVX2

  /// One chunk of W DEs. Index order: what, component, lane.
  struct alignas(64) Chunk {
    double p[6][3][W];     // F_a = s_a y_a / l_a, 0 where absent
    double h[6][W];        // thickness
    double c[6][W];        // h / l
    double m[6][W];        // 1 present, 0 absent
    double free[6][W];     // 1 free from the start
    double scale[6][W];    // s_a / l_a
    double lambda[4][W], mu[W];
    double f[6][3][W];
    double energy[W];
  };

  /// Sums over the eight corners in closed form. With the weight w = h_a h_b h_c of a corner and
  /// H_a = h_a- + h_a+, the shear terms of slot s on axis a need only the tensors
  ///   B_b = sum over the two slots t of axis b of h_t p_t p_t^T,
  /// since sum_t h_t (p_s.p_t) p_t = B_b p_s:
  ///   f_s = h_s/l_s [ N_s + mu (H_c B_b + H_b B_c) ] p_s.
  /// N_s holds the normal strains E_s = (p_s.p_s - 1)/2. Only its lambda part asks how many joints
  /// a corner has; if all are there, it separates as well.
  struct Sums {
    double E[6][W], H[3][W];
    double mE[3][W];      // sum over the two slots of an axis of h E
    double B[3][6][W];    // xx yy zz xy xz yz
    double lam[6][W];     // sum over the four corners of a slot of w lambda_e tr E, over h
    double lambda_energy[W];
  };

  template <bool FULL> DEFE_INLINE void sum_slots(const Chunk &k, Sums &sums)
  {
    auto &[E, H, mE, B, lam, lambda_energy] = sums;
    for (int s = 0; s < 6; ++s)
      for (int l = 0; l < W; ++l) {
        const double x = k.p[s][0][l], y = k.p[s][1][l], z = k.p[s][2][l];
        const double e = 0.5 * (x * x + y * y + z * z - 1.0);
        E[s][l] = FULL ? e : k.m[s][l] * e;
      }

    for (int a = 0; a < 3; ++a) {
      const auto &p = k.p[2 * a];
      const auto &q = k.p[2 * a + 1];
      for (int l = 0; l < W; ++l) {
        const double g = k.h[2 * a][l], h = k.h[2 * a + 1][l];
        const double px = p[0][l], py = p[1][l], pz = p[2][l];
        const double qx = q[0][l], qy = q[1][l], qz = q[2][l];
        const double gx = g * px, gy = g * py, hx = h * qx, hy = h * qy;
        H[a][l] = g + h;
        mE[a][l] = g * E[2 * a][l] + h * E[2 * a + 1][l];
        B[a][0][l] = gx * px + hx * qx;
        B[a][1][l] = gy * py + hy * qy;
        B[a][2][l] = g * pz * pz + h * qz * qz;
        B[a][3][l] = gx * py + hx * qy;
        B[a][4][l] = gx * pz + hx * qz;
        B[a][5][l] = gy * pz + hy * qz;
      }
    }
  }

  template <bool FULL> DEFE_INLINE void sum_traces(const Chunk &k, Sums &sums)
  {
    auto &[E, H, mE, B, lam, lambda_energy] = sums;
    if (FULL) {
      for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        for (int l = 0; l < W; ++l) {
          const double area = H[b][l] * H[c][l];
          const double others = H[c][l] * mE[b][l] + H[b][l] * mE[c][l];
          lam[2 * a][l] = k.lambda[3][l] * (area * E[2 * a][l] + others);
          lam[2 * a + 1][l] = k.lambda[3][l] * (area * E[2 * a + 1][l] + others);
        }
      }
    } else {
      for (int s = 0; s < 6; ++s)
        for (int l = 0; l < W; ++l) lam[s][l] = 0.0;
    }
    for (int l = 0; l < W; ++l) lambda_energy[l] = 0.0;
    if (FULL) {
      // energy is quadratic in E: half of E times its derivative
      for (int s = 0; s < 6; ++s)
        for (int l = 0; l < W; ++l) lambda_energy[l] += 0.5 * k.h[s][l] * lam[s][l] * E[s][l];
    } else {
      for (int corner = 0; corner < 8; ++corner) {
        const int r = corner_slot(corner, 0), s = corner_slot(corner, 1),
                  t = corner_slot(corner, 2);
        for (int l = 0; l < W; ++l) {
          const double joints = k.m[r][l] + k.m[s][l] + k.m[t][l];
          const double two = joints > 1.5 ? k.lambda[2][l] : k.lambda[1][l];
          const double lambda = joints > 2.5 ? k.lambda[3][l] : two;
          const double hr = k.h[r][l], hs = k.h[s][l], ht = k.h[t][l];
          const double trace = E[r][l] + E[s][l] + E[t][l];
          const double S = lambda * trace;
          lam[r][l] += hs * ht * S;
          lam[s][l] += hr * ht * S;
          lam[t][l] += hr * hs * S;
          lambda_energy[l] += 0.5 * hr * hs * ht * S * trace;
        }
      }
    }
  }

  DEFE_INLINE void forces_of(const Sums &sums, Chunk &k)
  {
    const auto &[E, H, mE, B, lam, lambda_energy] = sums;
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      for (int l = 0; l < W; ++l) {
        const double mu = k.mu[l];
        const double ub = mu * H[c][l], uc = mu * H[b][l];
        const double twice = 2.0 * mu * H[b][l] * H[c][l];
        const double xx = ub * B[b][0][l] + uc * B[c][0][l];
        const double yy = ub * B[b][1][l] + uc * B[c][1][l];
        const double zz = ub * B[b][2][l] + uc * B[c][2][l];
        const double xy = ub * B[b][3][l] + uc * B[c][3][l];
        const double xz = ub * B[b][4][l] + uc * B[c][4][l];
        const double yz = ub * B[b][5][l] + uc * B[c][5][l];
        for (int side = 0; side < 2; ++side) {
          const int s = 2 * a + side;
          const double x = k.p[s][0][l], y = k.p[s][1][l], z = k.p[s][2][l];
          const double N = lam[s][l] + twice * E[s][l];
          const double ratio = side ? k.c[s][l] : -k.c[s][l];    // s_a h_a / l_a
          k.f[s][0][l] = ratio * ((N + xx) * x + xy * y + xz * z);
          k.f[s][1][l] = ratio * (xy * x + (N + yy) * y + yz * z);
          k.f[s][2][l] = ratio * (xz * x + yz * y + (N + zz) * z);
        }
      }
    }
  }

  DEFE_INLINE void energy_of(const Sums &sums, Chunk &k)
  {
    const auto &[E, H, mE, B, lam, lambda_energy] = sums;
    for (int l = 0; l < W; ++l) k.energy[l] = lambda_energy[l];
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      const auto &P = B[b];
      const auto &Q = B[c];
      for (int l = 0; l < W; ++l) {
        const double e0 = E[2 * a][l], e1 = E[2 * a + 1][l];
        const double normal = k.h[2 * a][l] * e0 * e0 + k.h[2 * a + 1][l] * e1 * e1;
        const double shear = P[0][l] * Q[0][l] + P[1][l] * Q[1][l] + P[2][l] * Q[2][l] +
            2.0 * (P[3][l] * Q[3][l] + P[4][l] * Q[4][l] + P[5][l] * Q[5][l]);
        k.energy[l] += k.mu[l] * (H[b][l] * H[c][l] * normal + 0.5 * H[a][l] * shear);
      }
    }
  }

  DEFE_INLINE bool any_flat(const Sums &sums)
  {
    const auto &H = sums.H;
    bool any = false;
    for (int l = 0; l < W; ++l) {
      const double most = std::max(std::max(H[0][l], H[1][l]), H[2][l]);
      const double least = std::min(std::min(H[0][l], H[1][l]), H[2][l]);
      any |= least < cube_from * most;
    }
    return any;
  }

  /// Selective shear, a term for each longer axis a and shorter axis b. With q = p_a+ - p_a- and D = sum of h p on b it is
  /// -A (q.D)^2/2: absent joints have p = 0, so that q is that of the side that is left.
  template <bool FULL> __attribute__((noinline)) void selective_shear(const Sums &sums, Chunk &k)
  {
    const auto &H = sums.H;
    double inverse_H[3][W], inverse_length[6][W];
    for (int a = 0; a < 3; ++a)
      for (int l = 0; l < W; ++l) inverse_H[a][l] = 1.0 / H[a][l];
    for (int s = 0; s < 6; ++s)
      for (int l = 0; l < W; ++l) inverse_length[s][l] = k.m[s][l] * k.c[s][l] / k.h[s][l];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        if (a == b) continue;
        double drop[W];
        int any = 0;
        for (int l = 0; l < W; ++l) {
          const double ratio = H[b][l] * inverse_H[a][l];
          drop[l] = shear_to_drop(ratio * ratio);
          any += ratio < cube_from;
        }
        if (any == 0) continue;
        const int c = 3 - a - b, r = 2 * a, s = 2 * a + 1, t = 2 * b, u = 2 * b + 1;
        for (int l = 0; l < W; ++l) {
          const double hr = k.h[r][l], hs = k.h[s][l], ht = k.h[t][l], hu = k.h[u][l];
          double across = inverse_H[b][l], sides = 1.0;
          if (!FULL) {
            const double mr = k.m[r][l], ms = k.m[s][l];
            const double only_r = mr * (1.0 - ms) * (1.0 - k.free[s][l]);
            const double only_s = ms * (1.0 - mr) * (1.0 - k.free[r][l]);
            const double there = k.m[t][l] * ht + k.m[u][l] * hu;
            across = there > 0.0 ? 1.0 / there : 0.0;
            sides = mr * ms + only_r / (1.0 - drop[l] * hr * inverse_H[a][l]) +
                only_s / (1.0 - drop[l] * hs * inverse_H[a][l]);
          }
          const double A = drop[l] * k.mu[l] * H[c][l] * hr * hs * inverse_H[a][l] * across * sides;
          double q[3], D[3], g = 0.0;
          for (int i = 0; i < 3; ++i) {
            q[i] = k.p[s][i][l] - k.p[r][i][l];
            D[i] = ht * k.p[t][i][l] + hu * k.p[u][i][l];
            g += q[i] * D[i];
          }
          const double e = A * g;
          const double er = e * inverse_length[r][l], es = e * inverse_length[s][l];
          const double et = e * ht * inverse_length[t][l], eu = e * hu * inverse_length[u][l];
          k.energy[l] -= 0.5 * e * g;
          for (int i = 0; i < 3; ++i) {
            k.f[r][i][l] -= er * D[i];
            k.f[s][i][l] -= es * D[i];
            k.f[t][i][l] += et * q[i];
            k.f[u][i][l] -= eu * q[i];
          }
        }
      }
  }

  template <bool FULL> void corner_forces(Chunk &k)
  {
    Sums sums;
    sum_slots<FULL>(k, sums);
    sum_traces<FULL>(k, sums);
    forces_of(sums, k);
    energy_of(sums, k);
    if (any_flat(sums)) selective_shear<FULL>(sums, k);
  }

  /// Each DE by the formula for all joints if it has all, whatever those beside it have.
  void corner_forces_of_each(Chunk &k)
  {
    Chunk complete = k;
    corner_forces<true>(complete);
    corner_forces<false>(k);
    for (int l = 0; l < W; ++l) {
      bool all = true;
      for (int s = 0; s < 6; ++s) all = all && k.m[s][l] != 0.0;
      if (!all) continue;
      for (int s = 0; s < 6; ++s)
        for (int c = 0; c < 3; ++c) k.f[s][c][l] = complete.f[s][c][l];
      k.energy[l] = complete.energy[l];
    }
  }

  /// What the lattice says of eight DEs, one behind the other in its arrays.
  struct Eight {
    const int *self;
    const int (*nb)[6];
    const unsigned char *present, *material, *free;    // the last two may be null
    const double (*len)[6], (*half)[6];
    const LatticeRow *row;    // null: they are none

    Eight(const OrthogonalLattice &l, int first) :
        self(l.self + first), nb(l.nb + first), present(l.present + first),
        material(l.material ? l.material + first : nullptr),
        free(l.free ? l.free + first : nullptr), len(l.len + first), half(l.half + first),
        row(nullptr)
    {
      if (l.rows && l.rows[first / W].self >= 0) row = l.rows + first / W;
    }
    static std::uint64_t bytes(const unsigned char *p)
    {
      std::uint64_t all = 0;
      if (p) std::memcpy(&all, p, W);
      return all;
    }
    bool complete() const { return bytes(present) == 0x3f3f3f3f3f3f3f3fu; }
    bool any_complete() const { return std::count(present, present + W, 0x3f) > 0; }
  };
  static_assert(W == sizeof(std::uint64_t));

  /// The last ones of a list, fewer than eight: filled up with the last DE.
  struct Filled {
    int self[W], nb[W][6];
    unsigned char present[W], material[W] = {}, free[W] = {};
    double len[W][6], half[W][6];

    Filled(const OrthogonalLattice &lattice, int first)
    {
      for (int l = 0; l < W; ++l) {
        const int d = std::min(first + l, lattice.n - 1);
        self[l] = lattice.self[d];
        present[l] = lattice.present[d];
        if (lattice.material) material[l] = lattice.material[d];
        if (lattice.free) free[l] = lattice.free[d];
        std::copy_n(lattice.nb[d], 6, nb[l]);
        std::copy_n(lattice.len[d], 6, len[l]);
        std::copy_n(lattice.half[d], 6, half[l]);
      }
    }
    OrthogonalLattice lattice() const { return {W, self, nb, present, len, half, material, free}; }
  };

  /// to[s][l] = row[l][s]
  DEFE_INLINE void load_rows(const double (*row)[6], double (*to)[W])
  {
    for (int l = 0; l < W; l += 4)
      for (int s :
           {0, 2}) {    // the two of the middle come twice: nothing lies behind the last one
        const double *const from[4] = {&row[l][s], &row[l + 1][s], &row[l + 2][s], &row[l + 3][s]};
        double *const column[4] = {&to[s][l], &to[s + 1][l], &to[s + 2][l], &to[s + 3][l]};
        simd::transpose_four(from, column);
      }
  }

  /// \param material  of all lanes of the chunk before, -1: they had several
  DEFE_INLINE void load_moduli(const Eight &des, const CornerModuli *table, int &material, Chunk &k)
  {
    const int one = des.material ? des.material[0] : 0;
    const bool alike = Eight::bytes(des.material) == 0x0101010101010101u * one;
    if (alike && one == material) return;
    material = alike ? one : -1;
    for (int l = 0; l < W; ++l) {
      const Laws laws(table[des.material ? des.material[l] : 0]);
      for (int j = 1; j < 4; ++j) k.lambda[j][l] = laws.lambda[j];
      k.mu[l] = laws.mu;
    }
  }

  template <bool FULL>
  DEFE_INLINE void load_vectors(const Eight &des, const double *x, const double *points, Chunk &k)
  {
    for (int first = 0; first < W; first += 4) {
      const double *self[4], *other[4];
      for (int l = 0; l < 4; ++l) self[l] = x + 3 * static_cast<long>(des.self[first + l]);
      const simd::FourTriples here(self);
      for (int s = 0; s < 6; ++s) {
        for (int l = 0; l < 4; ++l) {
          const long j = des.nb[first + l][s];
          other[l] = j >= 0 ? x + 3 * j : points + 3 * ~j;
          if (!FULL && !(des.present[first + l] >> s & 1u)) other[l] = self[l];
        }
        auto &p = k.p[s];
        (simd::FourTriples(other) - here)
            .store_scaled(&k.scale[s][first], &p[0][first], &p[1][first], &p[2][first]);
      }
    }
  }

  template <bool FULL>
  DEFE_INLINE void load_vectors_of_row(const LatticeRow &row, const double *x, Chunk &k)
  {
    const double *self = x + 3 * static_cast<long>(row.self);
    for (int first = 0; first < W; first += 4) {
      const simd::TriplesInRow here(self + 3 * first);
      for (int s = 0; s < 6; ++s) {
        const double *other = row.nb[s] >= 0 ? x + 3 * static_cast<long>(row.nb[s]) : self;
        auto &p = k.p[s];
        (simd::TriplesInRow(other + 3 * first) - here)
            .store_scaled(&k.scale[s][first], &p[0][first], &p[1][first], &p[2][first]);
      }
    }
    if (FULL) return;
    for (int s = 0; s < 6; ++s)
      for (int c = 0; c < 3; ++c)
        for (int l = 0; l < W; ++l) k.p[s][c][l] = k.m[s][l] != 0.0 ? k.p[s][c][l] : 0.0;
  }

  /// Of each slot and lane 1 if the bit is set.
  DEFE_INLINE void load_bits(const unsigned char *bytes, double (*to)[W])
  {
    int bits[W];
    for (int l = 0; l < W; ++l) bits[l] = bytes[l];
    for (int s = 0; s < 6; ++s)
      for (int l = 0; l < W; ++l) to[s][l] = bits[l] >> s & 1;
  }

  /// Joint vectors by their lengths, and what belongs to them. FULL: all joints are there.
  template <bool FULL>
  DEFE_INLINE void load(const Eight &des, const double *x, const double *points, Chunk &k)
  {
    load_rows(des.half, k.h);
    load_rows(des.len, k.c);
    for (int s = 0; s < 6; ++s)
      for (int l = 0; l < W; ++l) {
        const double scale = (s & 1 ? 1.0 : -1.0) / k.c[s][l];
        k.scale[s][l] = scale;
        k.c[s][l] = k.h[s][l] * std::abs(scale);
        if (FULL) k.m[s][l] = 1.0;
        if (!FULL && !des.free) k.free[s][l] = 0.0;
      }
    if (!FULL) load_bits(des.present, k.m);
    if (!FULL && des.free) load_bits(des.free, k.free);
    if (des.row)
      load_vectors_of_row<FULL>(*des.row, x, k);
    else
      load_vectors<FULL>(des, x, points, k);
  }

  /// Half forces of the first DEs of a chunk.
  DEFE_INLINE void store(const Chunk &k, int first, int lanes, const HalfForces &out)
  {
    for (int s = 0; s < 6; ++s) {
      const auto &f = k.f[s];
      if (lanes == W && out.to_de == 3) {
        for (int l = 0; l < W; l += 4)
          simd::store_in_row(&f[0][l], &f[1][l], &f[2][l], out.of(first + l, s));
        continue;
      }
      for (int l = 0; l < lanes; ++l)
        for (int c = 0; c < 3; ++c) out.of(first + l, s)[c] = f[c][l];
    }
  }

}    // namespace

double corner_strain_orthogonal(const OrthogonalLattice &lattice, const double *x,
                                const double *points, const CornerModuli *table,
                                HalfForces half_force, double *energy, bool each_alone)
{
  Chunk k;
  double sum = 0.0;
  int material = -1;
  const auto compute = [&](const Eight &des, int first, int lanes) {
    load_moduli(des, table, material, k);
    if (des.complete()) {
      load<true>(des, x, points, k);
      corner_forces<true>(k);
    } else {
      load<false>(des, x, points, k);
      if (each_alone && des.any_complete())
        corner_forces_of_each(k);
      else
        corner_forces<false>(k);
    }
    store(k, first, lanes, half_force);
    if (energy)
      for (int l = 0; l < lanes; ++l) sum += energy[first + l] = k.energy[l];
  };

  int first = 0;
  for (; first + W <= lattice.n; first += W) compute(Eight(lattice, first), first, W);
  if (first < lattice.n) {
    const Filled rest(lattice, first);
    compute(Eight(rest.lattice(), 0), first, lattice.n - first);
  }
  return sum;
}

}    // namespace defe
