// How far displacements are from elasticity: check CASE_FOLDER NU FIELD.csv (id,ux,uy[,uz] in m)
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>
using Vector = std::vector<double>;
std::vector<Vector> read(const std::string& path) {  // numbers of a CSV file, without its header
  std::ifstream file(path);
  std::vector<Vector> rows;
  std::string line, cell;
  for (std::getline(file, line); std::getline(file, line) && (rows.emplace_back(), true);)
    for (std::stringstream cells(line); std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  return rows;
}
double largest(const Vector& f, size_t d) {  // longest vector of a field
  double most = 0, length = 0;
  for (size_t i = 0; i < f.size(); i++, most = std::fmax(most, length)) length = i % d ? std::hypot(length, f[i]) : std::fabs(f[i]);
  return most;
}
Vector sum(Vector a, const Vector& b, double s) {  // a + s b
  for (size_t i = 0; i < a.size(); i++) a[i] += s * b[i];
  return a;
}
Vector fit(Vector& rest, const std::vector<Vector>& columns) {  // least squares; what it leaves
  Vector c(columns.size(), 0.0);
  for (size_t step = 0, j = 0; step < 20000; step++, j = step % c.size()) {
    double up = 0, down = 1e-300;
    for (size_t i = 0; i < rest.size(); i++) up += rest[i] * columns[j][i], down += columns[j][i] * columns[j][i];
    c[j] += up / down, rest = sum(rest, columns[j], -up / down);
  }
  return c;
}
int main(int n, char** arg) {
  if (n != 4) return std::printf("usage: check CASE_FOLDER NU FIELD.csv\n"), 2;
  const std::string folder = std::string(arg[1]) + "/", own = arg[2];
  const size_t d = std::ifstream(folder + "tet4_nodes.csv").good() ? 3 : 2;
  const auto nodes = read(folder + (d == 3 ? "tet4_nodes.csv" : "tri3_nodes.csv"));
  std::map<int, Vector> given;
  for (auto& row : read(arg[3])) if (row.size() == d + 1) given[int(row[0])] = row;
  Vector wanted, found, by_nu;
  std::vector<Vector> turns(d == 3 ? 6 : 3);  // shifts along d axes, then turns
  for (auto& r : read(folder + "displacement.csv"))
    if (std::fabs(r[0] - std::stod(own)) < 1e-9 && given.count(int(r[1])))
      for (size_t k = 0; k < d; k++) {
        found.push_back(given[int(r[1])][k + 1]), wanted.push_back(r[2 + k]), by_nu.push_back(r[2 + 2 * d + k]);
        for (size_t p = 0; p < turns.size(); p++) turns[p].push_back(p == k);
        const Vector& x = nodes[int(r[1])];  // turn p is in the plane of axes p and p + 1
        for (size_t p = 0; p < (d == 3 ? 3 : 1); p++) turns[d + p].back() = k == p ? -x[1 + (p + 1) % d] : k == (p + 1) % d ? x[1 + p] : 0;
      }
  if (found.size() < 3 * d) return std::printf("%zu points of the case at nu = %s are in the field\n", found.size() / d, arg[2]), 2;
  const double size = largest(wanted, d);
  Vector away = sum(found, wanted, -1), shape = away, rest = away;
  const double scale = (turns.push_back(wanted), fit(shape, turns).back());
  const Vector rigid = sum(sum(away, wanted, -scale), shape, -1), m = fit(rest, {wanted, by_nu});
  std::printf("error %.6f\nscale %.6f\nrigid motion %.6f\nshape %.6f\nE / E of the case %.6f\nnu %.6f\n", largest(away, d) / size,
              std::fabs(scale), largest(rigid, d) / size, largest(shape, d) / size, 1 / (1 + m[0]), std::stod(own) + m[1] / (1 + m[0]));
}
