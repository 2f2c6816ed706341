// How far displacements are from elasticity: check CASE_FOLDER NU FIELD.csv; exit code 2 on bad input.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>
using Vector = std::vector<double>;
[[noreturn]] void refuse(const std::string& why) { std::exit((std::fprintf(stderr, "check: %s\n", why.c_str()), 2)); }
double number(const std::string& text, const std::string& where) {
  char* end; const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end || !(std::fabs(value) < 1e100)) refuse(where + ": '" + text + "'; give a finite number");
  return value;
}
std::vector<Vector> read(const std::string& path, const std::string& header) {  // rows below a header that begins so
  std::ifstream file(path); std::vector<Vector> rows; std::string line, first, cell;
  for (size_t at = 1; std::getline(file, line); at++) {
    const std::string where = path + " line " + std::to_string(at);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (at == 1 && (first = line + ",").rfind(header + ",", 0) != 0) refuse(where + ": '" + line + "'; the header is " + header);
    if (at == 1 || line.empty()) continue;
    std::stringstream cells(line + ","); rows.emplace_back();
    while (std::getline(cells, cell, ',')) rows.back().push_back(number(cell, where));
    size_t columns = 0; for (const char c : first) columns += c == ',';
    if (rows.back().size() != columns) refuse(where + ": as many values as the header has names, please");
  }
  return rows.empty() ? refuse(path + ": no such file, or no numbers in it") : rows;
}
double dot(const Vector& a, const Vector& b) { double s = 0; for (size_t i = 0; i < a.size(); i++) s += a[i] * b[i]; return s; }
Vector sum(Vector a, const Vector& b, double s) { for (size_t i = 0; i < a.size(); i++) a[i] += s * b[i]; return a; }
double largest(const Vector& f, size_t d) {  // longest vector of a field
  double most = 0, square = 0;
  for (size_t i = 0; i < f.size(); i++) square = f[i] * f[i] + (i % d ? square : 0), most = std::fmax(most, square);
  return std::sqrt(most);
}
Vector fit(Vector& rest, const std::vector<Vector>& columns) {  // least squares, one column after another; rest is what it leaves
  Vector c(columns.size(), 0.0);
  for (size_t step = 0, j = 0; step < 20000; step++, j = step % c.size()) {
    const double s = dot(rest, columns[j]) / (dot(columns[j], columns[j]) + 1e-300);
    c[j] += s, rest = sum(rest, columns[j], -s);
  }
  return c;
}
int main(int n, char** arg) {
  if (n != 4) refuse("give CASE_FOLDER NU FIELD.csv");
  const std::string folder = arg[1], path = arg[3]; const double nu = number(arg[2], "NU");
  const size_t d = std::ifstream(folder + "/tet4_nodes.csv").good() ? 3 : 2, turned = d == 3 ? 3 : 1;
  const auto nodes = read(folder + (d == 3 ? "/tet4_nodes.csv" : "/tri3_nodes.csv"), d == 3 ? "id,x,y,z" : "id,x,y");
  std::vector<Vector> given(nodes.size()), motions(d + turned);  // shifts along axes, then turns in planes of two axes
  for (const auto& row : read(path, d == 3 ? "id,ux,uy,uz" : "id,ux,uy")) {
    if (!(row[0] >= 0 && row[0] < double(nodes.size()) && row[0] == std::floor(row[0]))) refuse(path + ": id " + std::to_string(row[0]) + "; numbers of nodes, please");
    if (!given[size_t(row[0])].empty()) refuse(path + ": node " + std::to_string(size_t(row[0])) + " twice");
    given[size_t(row[0])] = row;
  }
