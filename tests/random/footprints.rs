//! Random footprints, valid by the simple-feature rules as those of a site are, and as awkward as these rules allow.

use geo::{Area, BoundingRect, LineString, MultiPolygon, Polygon, Rotate, Translate, Validation, coord};

use super::draw::Draw;

/// How the footprints are made, each with its weight.
const SHAPES: [(&str, usize); 16] = [
    ("rectangle", 12),
    ("l", 10),
    ("u", 6),
    ("t", 6),
    ("courtyards", 6),
    ("needles", 6),
    ("collinear", 6),
    ("jogs", 8),
    ("star", 6),
    ("thousand", 1),
    ("parts", 6),
    ("tiny", 4),
    ("huge", 1),
    ("stairs", 6),
    ("union", 12),
    ("triangle", 4),
];

/// A random footprint in local metres and the name of its shape.
pub fn footprint(draw: &mut Draw) -> (MultiPolygon<f64>, &'static str) {
    let total: usize = SHAPES.iter().map(|(_, weight)| weight).sum();
    let mut ticket = draw.below(total);
    let mut name = SHAPES[0].0;
    for (shape, weight) in SHAPES {
        if ticket < weight {
            name = shape;
            break;
        }
        ticket -= weight;
    }
    let shape = shape(name, draw);
    let turned = match draw.below(3) {
        0 => shape,
        1 => shape.rotate_around_point(draw.between(0.0, 360.0), geo::point! { x: 0.0, y: 0.0 }),
        // Nearly parallel to the axes: planes that nearly coincide with those of the box.
        _ => shape.rotate_around_point(draw.across(1e-5, 1.0), geo::point! { x: 0.0, y: 0.0 }),
    };
    let moved = turned.translate(draw.between(-50.0, 50.0), draw.between(-50.0, 50.0));
    if moved.is_valid() && moved.unsigned_area() > 0.0 {
        return (moved, name);
    }
    // What the repair of footprints does.
    let united = geo::unary_union(&moved.0);
    if united.is_valid() && united.unsigned_area() > 0.0 { (united, name) } else { (rectangle(8.0, 6.0), "rectangle") }
}

fn polygon(corners: Vec<(f64, f64)>) -> Polygon<f64> {
    geo::Orient::orient(&Polygon::new(LineString::from(corners), Vec::new()), geo::orient::Direction::Default)
}

fn rectangle(width: f64, depth: f64) -> MultiPolygon<f64> {
    MultiPolygon(vec![block(0.0, 0.0, width, depth)])
}

fn block(x: f64, y: f64, width: f64, depth: f64) -> Polygon<f64> {
    polygon(vec![(x, y), (x + width, y), (x + width, y + depth), (x, y + depth)])
}

fn shape(name: &str, draw: &mut Draw) -> MultiPolygon<f64> {
    let (w, d) = (draw.across(3.0, 40.0), draw.across(3.0, 40.0));
    let (a, b) = (draw.between(0.1, 0.9), draw.between(0.1, 0.9));
    let one = |corners: Vec<(f64, f64)>| MultiPolygon(vec![polygon(corners)]);
    match name {
        "l" => one(vec![(0.0, 0.0), (w, 0.0), (w, b * d), (a * w, b * d), (a * w, d), (0.0, d)]),
        "u" => {
            let (c, e) = (a * w / 2.0, w - draw.between(0.1, 0.4) * w);
            one(vec![(0.0, 0.0), (w, 0.0), (w, d), (e, d), (e, b * d), (c, b * d), (c, d), (0.0, d)])
        }
        "t" => {
            let (c, e) = (a * w / 2.0, w - draw.between(0.05, 0.4) * w);
            let f = b * d;
            one(vec![(c, 0.0), (e, 0.0), (e, f), (w, f), (w, d), (0.0, d), (0.0, f), (c, f)])
        }
        "courtyards" => {
            let (w, d) = (w + 8.0, d + 8.0);
            let columns = 1 + draw.below(3);
            let cell = w / columns as f64;
            let holes = (0..columns).map(|i| {
                // Some come within a millimetre of the outer wall or of each other.
                let gap = draw.of(&[0.0005_f64, 0.002, 0.05, 0.4, 1.5]).min(cell / 3.0);
                let (x, y) = (i as f64 * cell + gap, gap);
                let hole = block(x, y, cell - 2.0 * gap, (d - 2.0 * gap) * draw.between(0.3, 1.0));
                LineString(hole.exterior().0.iter().rev().copied().collect())
            });
            MultiPolygon(vec![Polygon::new(block(0.0, 0.0, w, d).exterior().clone(), holes.collect())])
        }
        "needles" => {
            let thin = draw.across(1e-4, 0.3);
            let long = draw.between(0.5, 10.0);
            let (x, y) = (a * w, b * d);
            if draw.chance(0.5) {
                one(vec![(0.0, 0.0), (x, 0.0), (x + thin / 2.0, -long), (x + thin, 0.0), (w, 0.0), (w, d), (0.0, d)])
            } else {
                let notch = long.min(d - 0.1);
                one(vec![
                    (0.0, 0.0),
                    (w, 0.0),
                    (w, y),
                    (w - notch.min(w - 0.1), y + thin / 2.0),
                    (w, y + thin),
                    (w, d + thin),
                    (0.0, d + thin),
                ])
            }
        }
        "collinear" | "jogs" => wobbly(name == "jogs", &rectangle(w, d), draw),
        "star" | "thousand" => {
            let count = if name == "star" { 5 + draw.below(50) } else { 1000 };
            let roughness = draw.of(&[0.0, 0.02, 0.3]);
            let corner = |i: usize, r: f64| {
                let angle = std::f64::consts::TAU * i as f64 / count as f64;
                (r * angle.cos(), r * angle.sin())
            };
            one((0..count).map(|i| corner(i, w / 2.0 * (1.0 + roughness * draw.between(-1.0, 1.0)))).collect())
        }
        "parts" => {
            let gap = draw.of(&[0.0, 0.0, 1e-4, 0.01, 0.5, 4.0]);
            let count = 2 + draw.below(5);
            let mut x = 0.0;
            let parts = (0..count).map(|i| {
                let (w, d) = (draw.between(2.0, 10.0), draw.between(2.0, 10.0));
                let y = if gap == 0.0 { [0.0, d][i % 2] } else { draw.between(-3.0, 3.0) };
                let part = block(x, y, w, d);
                x += w + gap;
                part
            });
            MultiPolygon(parts.collect())
        }
        "tiny" => rectangle(draw.across(0.05, 2.0), draw.across(0.05, 2.0)),
        "huge" => {
            let outer = block(0.0, 0.0, 300.0, draw.between(20.0, 300.0));
            MultiPolygon(vec![outer])
        }
        "stairs" => {
            let count = 2 + draw.below(20);
            let (run, rise) = (draw.across(0.01, 2.0), draw.across(0.01, 2.0));
            let mut corners = vec![(0.0, 0.0)];
            for i in 0..count {
                let (x, y) = (i as f64 * run, i as f64 * rise);
                corners.extend([(x + run, y), (x + run, y + rise)]);
            }
            corners.push((0.0, count as f64 * rise + draw.between(0.0, 5.0)));
            one(corners)
        }
        "union" => {
            // Rectangles on a coarse grid: edges in line, holes, and corners that touch.
            let grid = draw.of(&[0.25, 1.0, 2.0]);
            let mut on_grid = |from: f64, to: f64| (draw.between(from, to) / grid).round() * grid;
            let blocks: Vec<Polygon<f64>> = (0..8)
                .map(|_| {
                    let (x, y) = (on_grid(0.0, 20.0), on_grid(0.0, 20.0));
                    block(x, y, on_grid(0.0, 9.0) + grid, on_grid(0.0, 9.0) + grid)
                })
                .collect();
            let count = 2 + draw.below(7);
            geo::unary_union(&blocks[..count])
        }
        "triangle" => one(vec![(0.0, 0.0), (w, draw.between(-1.0, 1.0)), (a * w, d)]),
        _ => rectangle(w, d),
    }
}

/// More vertices on the outline: on its edges, or a little beside them.
fn wobbly(beside: bool, footprint: &MultiPolygon<f64>, draw: &mut Draw) -> MultiPolygon<f64> {
    let Some(rect) = footprint.bounding_rect() else { return footprint.clone() };
    let mut corners = Vec::new();
    for edge in footprint.0[0].exterior().lines() {
        let count = draw.below(8);
        let mut at: Vec<f64> = (0..count).map(|_| draw.unit()).collect();
        at.push(0.0);
        if draw.chance(0.3) {
            at.push(draw.across(1e-6, 1e-2) / rect.width());
        }
        at.sort_by(f64::total_cmp);
        for t in at {
            let off = if beside && t > 0.0 { draw.across(1e-5, 0.3) * draw.of(&[-1.0, 1.0]) } else { 0.0 };
            let (dx, dy) = (edge.end.x - edge.start.x, edge.end.y - edge.start.y);
            let length = dx.hypot(dy);
            let base = coord! { x: edge.start.x + t * dx, y: edge.start.y + t * dy };
            corners.push((base.x - off * dy / length, base.y + off * dx / length));
        }
    }
    MultiPolygon(vec![polygon(corners)])
}
