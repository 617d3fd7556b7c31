// The Voronoi diagram of segments by Boost.Polygon, behind a C interface: the peer of
// benchmarks/chain.py. Coordinates are whole numbers; segments may share ends but not cross.
#include <boost/polygon/polygon.hpp>
#include <boost/polygon/voronoi.hpp>
#include <vector>

using Point = boost::polygon::point_data<int>;
using Segment = boost::polygon::segment_data<int>;

// segments: 4 n whole numbers. places: room for the ends of every edge between two sites, or
// null for the bare diagram. Returns the number of edges written, or of all without places.
extern "C" long segment_diagram(const int *segments, long n, double *places) {
    std::vector<Segment> sites;
    sites.reserve(n);
    for (long i = 0; i < n; i++) {
        const int *s = segments + 4 * i;
        sites.emplace_back(Point(s[0], s[1]), Point(s[2], s[3]));
    }
    boost::polygon::voronoi_diagram<double> diagram;
    boost::polygon::construct_voronoi(sites.begin(), sites.end(), &diagram);
    if (!places) return long(diagram.num_edges() / 2);
    long count = 0;
    for (const auto &edge : diagram.edges()) {
        if (&edge > edge.twin() || !edge.is_primary() || !edge.is_finite()) continue;
        double *p = places + 4 * count++;
        p[0] = edge.vertex0()->x(), p[1] = edge.vertex0()->y();
        p[2] = edge.vertex1()->x(), p[3] = edge.vertex1()->y();
    }
    return count;
}
