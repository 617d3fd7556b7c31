// CGAL's Delaunay triangulation and Boost.Polygon's Voronoi diagram of points, as two C functions
// for benchmarks/voronoi.py. Build with -DWITH_CGAL, -DWITH_BOOST or both.
//
// Both take n sites as xy[2 n]. With pairs == nullptr they only build the diagram and return its
// number of vertices; else they also write, as planner.voronoi does, the pairs of sites that
// share an edge to pairs[2 * 3 n] and the finite vertices to vertices[2 * 2 n], and return the
// number of pairs.
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#ifdef WITH_CGAL
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Corner = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using Triangulation =
    CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Corner>>;

extern "C" long cgal_diagram(const double *xy, long n, int *pairs, double *vertices) {
    Triangulation triangulation;
    if (!pairs) {
        std::vector<Kernel::Point_2> sites;
        sites.reserve(n);
        for (long i = 0; i < n; i++) sites.emplace_back(xy[2 * i], xy[2 * i + 1]);
        triangulation.insert(sites.begin(), sites.end());
        return triangulation.number_of_faces();
    }
    std::vector<std::pair<Kernel::Point_2, int>> sites;
    sites.reserve(n);
    for (long i = 0; i < n; i++)
        sites.emplace_back(Kernel::Point_2(xy[2 * i], xy[2 * i + 1]), static_cast<int>(i));
    triangulation.insert(sites.begin(), sites.end());
    for (auto face = triangulation.finite_faces_begin(); face != triangulation.finite_faces_end();
         ++face) {
        const auto centre = triangulation.circumcenter(face);
        *vertices++ = centre.x();
        *vertices++ = centre.y();
    }
    long count = 0;
    for (auto edge = triangulation.finite_edges_begin(); edge != triangulation.finite_edges_end();
         ++edge, ++count) {
        *pairs++ = edge->first->vertex(Triangulation::cw(edge->second))->info();
        *pairs++ = edge->first->vertex(Triangulation::ccw(edge->second))->info();
    }
    return count;
}
#endif

#ifdef WITH_BOOST
#include <boost/polygon/voronoi.hpp>

// Boost's sites have 32-bit integer coordinates; the caller scales them to fill that range.
extern "C" long boost_diagram(const double *xy, long n, int *pairs, double *vertices) {
    using Point = boost::polygon::point_data<int>;
    std::vector<Point> sites;
    sites.reserve(n);
    for (long i = 0; i < n; i++)
        sites.emplace_back(static_cast<int>(std::lround(xy[2 * i])),
                           static_cast<int>(std::lround(xy[2 * i + 1])));
    boost::polygon::voronoi_diagram<double> diagram;
    boost::polygon::construct_voronoi(sites.begin(), sites.end(), &diagram);
    if (!pairs) return diagram.num_vertices();
    for (const auto &vertex : diagram.vertices()) {
        *vertices++ = vertex.x();
        *vertices++ = vertex.y();
    }
    long count = 0;
    for (const auto &edge : diagram.edges()) {
        const auto left = edge.cell()->source_index(), right = edge.twin()->cell()->source_index();
        if (left > right) continue;
        *pairs++ = static_cast<int>(left);
        *pairs++ = static_cast<int>(right);
        count++;
    }
    return count;
}
#endif
