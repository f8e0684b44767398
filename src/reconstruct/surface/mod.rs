//! Surface (paper, section 3.5): the facets between inside and outside cells, merged into polygons.
