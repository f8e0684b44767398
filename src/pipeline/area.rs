//! Areas and boxes that points lie in: those of `filters.crop` and `readers.copc`.

use geo::{BoundingRect, Coord, Intersects, LineString, MultiPolygon, Polygon};

use super::expression::Misfit;
use crate::source::points::Extent;

/// What a point may lie in. Its border belongs to it, but for [`Self::Near`].
#[derive(Debug, Clone, PartialEq)]
pub enum Area {
    /// A box; two-dimensional ones are open up and down.
    Box(Extent),
    /// Polygons, open up and down, and the box around them.
    Polygons(MultiPolygon<f64>, Extent),
    /// What lies nearer than the distance to a place; to one without a height, in the plan.
    Near {
        /// The place.
        place: [f64; 2],
        /// Its height, for a sphere in place of a cylinder.
        height: Option<f64>,
        /// The distance.
        distance: f64,
    },
}

impl Area {
    /// Reads a box as PDAL writes it: `([xmin, xmax], [ymin, ymax])` or with `[zmin, zmax]` as well.
    ///
    /// # Errors
    /// It is of another form.
    pub fn of_bounds(text: &str) -> Result<Self, Misfit> {
        let fault = || Misfit::new(format!("`{text}`"), "([xmin, xmax], [ymin, ymax]) or ([…], […], [zmin, zmax])");
        // A CRS may follow after a slash.
        if text.contains('/') {
            return Err(Misfit::new(format!("`{text}`"), "bounds without a CRS behind them: give it as `a_srs`"));
        }
        let inside = text.trim().strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).ok_or_else(fault)?;
        let mut extent = Extent { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };
        let mut axes = 0;
        for part in inside.split(']') {
            let part = part.trim().trim_start_matches(',').trim();
            if part.is_empty() {
                continue;
            }
            let range = part.strip_prefix('[').ok_or_else(fault)?;
            let (low, high) = range.split_once(',').ok_or_else(fault)?;
            let number = |text: &str| text.trim().parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(fault);
            let (low, high) = (number(low)?, number(high)?);
            if axes == 3 || low > high {
                return Err(fault());
            }
            (extent.min[axes], extent.max[axes]) = (low, high);
            axes += 1;
        }
        if axes < 2 { Err(fault()) } else { Ok(Self::Box(extent)) }
    }

    /// Reads a `POLYGON` or `MULTIPOLYGON` in WKT; heights are passed over.
    ///
    /// # Errors
    /// It is of another form.
    pub fn of_wkt(text: &str) -> Result<Self, Misfit> {
        let shown: String = text.chars().take(60).collect();
        let fault = || Misfit::new(format!("`{shown}`"), "WKT such as POLYGON((0 0, 10 0, 10 10, 0 0))");
        let text = text.trim();
        let open = text.find('(').ok_or_else(fault)?;
        let words: Vec<String> = text[..open].split_whitespace().map(str::to_uppercase).collect();
        let is_multi = match words.first().map(String::as_str) {
            Some("POLYGON") => false,
            Some("MULTIPOLYGON") => true,
            _ => return Err(fault()),
        };
        let mut reader = Brackets { rest: &text[open..] };
        let polygons = if is_multi {
            reader.list(&mut |reader| reader.list(&mut Brackets::ring)).ok_or_else(fault)?
        } else {
            vec![reader.list(&mut Brackets::ring).ok_or_else(fault)?]
        };
        if !reader.rest.trim().is_empty() {
            return Err(fault());
        }
        let polygon = |mut rings: Vec<LineString<f64>>| {
            let outer = if rings.is_empty() { LineString::new(Vec::new()) } else { rings.remove(0) };
            Polygon::new(outer, rings)
        };
        let polygons = MultiPolygon::new(polygons.into_iter().map(polygon).collect());
        if polygons.iter().any(|polygon| polygon.exterior().0.len() < 4) {
            return Err(fault());
        }
        Self::of_polygons(polygons).ok_or_else(fault)
    }

    /// Polygons; `None` when they are empty.
    pub fn of_polygons(polygons: MultiPolygon<f64>) -> Option<Self> {
        let rect = polygons.bounding_rect()?;
        let (min, max) = (rect.min(), rect.max());
        let extent = Extent { min: [min.x, min.y, f64::NEG_INFINITY], max: [max.x, max.y, f64::INFINITY] };
        Some(Self::Polygons(polygons, extent))
    }

    /// Reads a `POINT` in WKT, to be taken with a distance.
    ///
    /// # Errors
    /// It is of another form.
    pub fn near_wkt(text: &str, distance: f64) -> Result<Self, Misfit> {
        let fault = || Misfit::new(format!("`{text}`"), "WKT such as POINT(85000 447000)");
        let upper = text.trim().to_uppercase();
        let rest = upper.strip_prefix("POINT").ok_or_else(fault)?.trim_start();
        let rest = rest.strip_prefix('Z').unwrap_or(rest).trim();
        let inside = rest.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).ok_or_else(fault)?;
        let numbers: Option<Vec<f64>> =
            inside.split_whitespace().map(|n| n.parse::<f64>().ok().filter(|n| n.is_finite())).collect();
        match numbers.as_deref() {
            Some([x, y]) => Ok(Self::Near { place: [*x, *y], height: None, distance }),
            Some([x, y, z]) => Ok(Self::Near { place: [*x, *y], height: Some(*z), distance }),
            _ => Err(fault()),
        }
    }

    /// Whether a point lies in it.
    pub fn has(&self, [x, y, z]: [f64; 3]) -> bool {
        match self {
            Self::Box(extent) => in_box(extent, [x, y, z]),
            Self::Polygons(polygons, extent) => in_box(extent, [x, y, z]) && polygons.intersects(&Coord { x, y }),
            Self::Near { place, height, distance } => {
                let (dx, dy, dz) = (x - place[0], y - place[1], height.map_or(0.0, |height| z - height));
                dx * dx + dy * dy + dz * dz < distance * distance
            }
        }
    }

    /// The box around it.
    pub fn extent(&self) -> Extent {
        match self {
            Self::Box(extent) | Self::Polygons(_, extent) => *extent,
            Self::Near { place: [x, y], height, distance } => {
                let z = height.map_or([f64::NEG_INFINITY, f64::INFINITY], |z| [z - distance, z + distance]);
                Extent { min: [x - distance, y - distance, z[0]], max: [x + distance, y + distance, z[1]] }
            }
        }
    }

    /// Whether the box around it touches a rectangle.
    pub fn touches(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let extent = self.extent();
        (0..2).all(|axis| extent.min[axis] <= high[axis] && extent.max[axis] >= low[axis])
    }

    /// What is left of areas that were scanned within the boxes around areas that are kept.
    pub fn clip(kept: &[Self], scanned: &[Extent]) -> Vec<Extent> {
        let cut = |scanned: &Extent, kept: Extent| {
            let mut cut = *scanned;
            for axis in 0..2 {
                cut.min[axis] = cut.min[axis].max(kept.min[axis]);
                cut.max[axis] = cut.max[axis].min(kept.max[axis]);
            }
            (cut.min[0] <= cut.max[0] && cut.min[1] <= cut.max[1]).then_some(cut)
        };
        kept.iter().flat_map(|area| scanned.iter().filter_map(move |scanned| cut(scanned, area.extent()))).collect()
    }
}

fn in_box(extent: &Extent, position: [f64; 3]) -> bool {
    (0..3).all(|axis| extent.min[axis] <= position[axis] && position[axis] <= extent.max[axis])
}

/// Reads lists in brackets that are parted by commas.
struct Brackets<'a> {
    rest: &'a str,
}

impl Brackets<'_> {
    fn take(&mut self, sign: char) -> bool {
        let rest = self.rest.trim_start();
        let taken = rest.strip_prefix(sign);
        self.rest = taken.unwrap_or(rest);
        taken.is_some()
    }

    fn list<T>(&mut self, item: &mut dyn FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        if !self.take('(') {
            return None;
        }
        let mut items = Vec::new();
        loop {
            items.push(item(self)?);
            if !self.take(',') {
                return self.take(')').then_some(items);
            }
        }
    }

    fn ring(&mut self) -> Option<LineString<f64>> {
        let coordinates = self.list(&mut |reader| {
            let end = reader.rest.find([',', ')'])?;
            let numbers: Option<Vec<f64>> = reader.rest[..end]
                .split_whitespace()
                .map(|number| number.parse::<f64>().ok().filter(|n| n.is_finite()))
                .collect();
            let numbers = numbers.filter(|numbers| (2..=4).contains(&numbers.len()))?;
            reader.rest = &reader.rest[end..];
            Some(Coord { x: *numbers.first()?, y: *numbers.get(1)? })
        })?;
        Some(LineString::new(coordinates))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_include_their_border() {
        let area = Area::of_bounds("([0, 10],[-5.5,1e1])").unwrap();
        assert!(area.has([0.0, -5.5, 1e9]) && area.has([10.0, 10.0, 0.0]));
        assert!(!area.has([10.1, 0.0, 0.0]) && !area.has([0.0, -5.6, 0.0]));
        let area = Area::of_bounds(" ( [0,1], [0,1], [2, 3] ) ").unwrap();
        assert!(area.has([0.5, 0.5, 2.0]) && !area.has([0.5, 0.5, 1.9]));
        for bad in [
            "",
            "0,1,0,1",
            "([0,1])",
            "([0,1],[2,1])",
            "([0,1],[0,x])",
            "([0,1],[0,1],[0,1],[0,1])",
            "([0,1],[0,1])/EPSG:7415",
        ] {
            assert!(Area::of_bounds(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn polygons_have_holes() {
        let square = "POLYGON((0 0, 10 0, 10 10, 0 10, 0 0), (4 4, 6 4, 6 6, 4 6, 4 4))";
        let area = Area::of_wkt(square).unwrap();
        assert!(area.has([1.0, 1.0, 0.0]) && area.has([0.0, 5.0, 0.0]));
        assert!(!area.has([5.0, 5.0, 0.0]) && !area.has([11.0, 5.0, 0.0]));
        let area = Area::of_wkt("multipolygon z(((0 0 1,1 0 1,1 1 1,0 0 1)),((5 5 1,6 5 1,6 6 1,5 5 1)))").unwrap();
        assert!(area.has([0.9, 0.1, 0.0]) && area.has([5.9, 5.1, 0.0]) && !area.has([3.0, 3.0, 0.0]));
        for bad in [
            "",
            "POINT(0 0)",
            "POLYGON((0 0, 1 0))",
            "POLYGON((0 0, 1 0, 1 1, 0 0)",
            "POLYGON((0 0, 1 a, 1 1, 0 0))",
            "POLYGON((0 0, 1 0, 1 1, 0 0)) x",
        ] {
            assert!(Area::of_wkt(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn circles_and_spheres_leave_their_border_out() {
        let circle = Area::near_wkt("POINT(1 1)", 2.0).unwrap();
        assert!(circle.has([2.9, 1.0, 99.0]) && !circle.has([3.0, 1.0, 0.0]));
        let sphere = Area::near_wkt("Point Z (1 1 5)", 2.0).unwrap();
        assert!(sphere.has([1.0, 1.0, 6.9]) && !sphere.has([1.0, 1.0, 2.0]));
        assert!(Area::near_wkt("POINT(1)", 1.0).is_err());
    }
}
