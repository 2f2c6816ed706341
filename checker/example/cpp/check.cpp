// How far displacements are from elasticity: check CASE_FOLDER NU FIELD.csv; exit code 2 on bad input
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <valarray>
#include <vector>
using Rows = std::vector<std::vector<double>>;
using Field = std::valarray<double>;  // components of all points, those of one point together
void refuse(const std::string& why) { std::exit((std::fprintf(stderr, "check: %s\n", why.c_str()), 2)); }
Rows read(const std::string& path, const std::string& header) {  // numbers below a header that begins so
  std::ifstream file(path); std::string line;
  if (!std::getline(file, line) || line.rfind(header, 0)) refuse(path + ": no such file, or no header " + header);
  const size_t columns = 1 + size_t(std::count(line.begin(), line.end(), ','));
  Rows rows;
  while (std::getline(file, line)) {
    std::stringstream cells(line);
    char after = (rows.push_back({}), ',');  // a number: >> takes NaN, infinity and text for none
    for (double x; after == ',' && cells >> x; cells >> after) rows.back().push_back(x), after = 0;
    if (after || rows.back().size() != columns) refuse(path + ": '" + line + "'; give finite numbers as its header says");
  }
  return rows;
}
double largest(const Field& f, size_t d, size_t i = 0) {  // length of the longest vector from number i on
  return i < f.size() ? std::max(std::hypot(f[i], f[i + 1], d == 3 ? f[i + 2] : 0), largest(f, d, i + d)) : 0;
}
Field fit(Field& rest, const std::vector<Field>& columns) {  // least squares, one by one; rest becomes what is left
  Field c(columns.size());
  for (size_t step = 0, j = 0; step < 20000; step++, j = step % c.size()) {
    const double s = (rest * columns[j]).sum() / ((columns[j] * columns[j]).sum() + 1e-300);
    c[j] += s, rest -= s * columns[j];
  }
  return c;
}
int main(int n, char** arg) {
  std::stringstream ratio(n == 4 ? arg[2] : ""); double nu = NAN;
  if (!(ratio >> nu && ratio.eof())) refuse("give CASE_FOLDER NU FIELD.csv, NU one of the case's ratios");
  const std::string folder = arg[1] + std::string("/"), path = arg[3];
  const size_t d = std::ifstream(folder + "tet4_nodes.csv") ? 3 : 2, turns = 2 * d - 3;
  const Rows nodes = read(folder + (d == 3 ? "tet4_nodes.csv" : "tri3_nodes.csv"), "id,x,y");
  std::map<double, std::vector<double>> known, given;  // by node
  for (auto& r : read(folder + "displacement.csv", "nu,id,ux,uy")) if (std::fabs(r[0] - nu) < 1e-9) known[r[1]] = r;
  for (auto& r : read(path, "id,ux,uy")) if (r.size() <= d || !given.emplace(r[0], r).second) refuse(path + ": no uz, or a node twice");
  Field wanted(nodes.size() * d), found = wanted, by_nu = wanted;
  std::vector<Field> parts(d + turns + 1, wanted);  // shifts along axes, turns from each to the next, the scale
  for (size_t i = 0, k = 0; i < wanted.size(); k = ++i % d) {
    const auto &u = given[i / d], &r = known[i / d], &x = nodes[i / d];
    if (r.empty() || u.empty()) refuse(r.empty() ? folder + ": no answer for this NU" : path + ": no node " + std::to_string(i / d));
    found[i] = u[1 + k], parts[k][i] = 1, parts.back()[i] = wanted[i] = r[2 + k], by_nu[i] = r[2 + 2 * d + k];
    for (size_t p = 0, q = 1; p < turns; q = (++p + 1) % d) parts[d + p][i] = k == p ? -x[1 + q] : k == q ? x[1 + p] : 0;
  }
  Field shape = found - wanted, rest = shape;
  const double size = largest(wanted, d), scale = fit(shape, parts)[d + turns];
  const Field rigid = found - wanted - scale * wanted - shape, m = fit(rest, {wanted, by_nu});
  std::printf("error %.6f\nscale %.6f\nrigid motion %.6f\nshape %.6f\nE / E of the case %.6f\nnu %.6f\n", largest(found - wanted, d) / size,
              std::fabs(scale), largest(rigid, d) / size, largest(shape, d) / size, 1 / (1 + m[0]), nu + m[1] / (1 + m[0]));
}
