//! Random roofs and clouds over a footprint: what a scanner sees, and what it never should.

use geo::{Area, BoundingRect, Contains, MultiPolygon};
use nalgebra::Point3;

use super::draw::Draw;

/// The most points of most buildings, and of the others; larger ones are scanned more thinly.
const MOST_POINTS: [f64; 2] = [600.0, 12_000.0];

/// A roof as a height above the plan.
type Roof = Box<dyn Fn(f64, f64) -> Option<f64>>;

const ROOFS: [&str; 12] =
    ["flat", "gable", "hip", "mansard", "steps", "dormers", "dome", "sawtooth", "planes", "waves", "terraces", "cone"];

/// What is wrong with a cloud; most have nothing.
const ILLS: [&str; 18] = [
    "none",
    "none",
    "none",
    "none",
    "none",
    "half",
    "holes",
    "strays",
    "duplicates",
    "line",
    "three",
    "one",
    "nowhere",
    "walls",
    "noise",
    "far",
    "not-numbers",
    "place",
];

/// The points of a building, the height of its ground, and what they are.
pub struct Cloud {
    pub points: Vec<Point3<f64>>,
    pub ground: f64,
    pub eaves: f64,
    pub roof: &'static str,
    pub ill: &'static str,
}

/// A random cloud over a footprint.
pub fn cloud(footprint: &MultiPolygon<f64>, draw: &mut Draw) -> Cloud {
    let name = draw.of(&ROOFS);
    let ill = draw.of(&ILLS);
    let Some(rect) = footprint.bounding_rect() else {
        return Cloud { points: Vec::new(), ground: 0.0, eaves: 0.0, roof: name, ill };
    };
    let base = draw.of(&[0.0, 0.0, -4.0, 450.0, 3000.0]);
    let eaves = base + draw.across(0.5, 30.0);
    let centre = [rect.center().x, rect.center().y];
    let size = rect.width().max(rect.height()) / 2.0;
    let roof = roof(name, centre, size, eaves, draw);
    let most = MOST_POINTS[usize::from(draw.chance(0.04))];
    let density = draw.across(0.3, 60.0).min(most / (rect.width() * rect.height()));
    let noise = draw.of(&[0.0, 0.01, 0.03, 0.1, 0.5]);
    let count = (density * rect.width() * rect.height()).ceil() as usize;
    let mut points = Vec::new();
    for _ in 0..count {
        let (x, y) = (draw.between(rect.min().x, rect.max().x), draw.between(rect.min().y, rect.max().y));
        if footprint.contains(&geo::point! { x: x, y: y })
            && let Some(z) = roof(x, y)
        {
            points.push(Point3::new(x, y, z + noise * draw.normal()));
        }
    }
    if points.is_empty() && footprint.unsigned_area() > 0.0 {
        points.push(Point3::new(centre[0], centre[1], eaves));
    }
    spoil(&mut points, ill, [base, eaves], draw);
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    if ill != "duplicates" {
        points.dedup();
    }
    let ground = match draw.below(12) {
        // The ground above the eaves, or just below the roof.
        0 => eaves + draw.between(-0.5, 3.0),
        1 => eaves - draw.across(1e-4, 0.1),
        2 => base - draw.between(0.0, 200.0),
        _ => base + draw.between(-0.5, 0.5),
    };
    Cloud { points, ground, eaves, roof: name, ill }
}

fn roof(name: &str, [cx, cy]: [f64; 2], size: f64, eaves: f64, draw: &mut Draw) -> Roof {
    let (slope, angle) = (draw.between(0.05, 1.8), draw.between(0.0, std::f64::consts::PI));
    let angle = draw.of(&[0.0, angle]);
    let (sin, cos) = angle.sin_cos();
    let shift = draw.between(-0.5, 0.5) * size;
    // Along and across the ridge.
    let axes = move |x: f64, y: f64| {
        let (dx, dy) = (x - cx, y - cy);
        [dx * cos + dy * sin - shift, dy * cos - dx * sin]
    };
    let step = draw.across(0.02, 6.0);
    match name {
        "gable" => Box::new(move |x, y| Some(eaves + slope * (size - axes(x, y)[1].abs()).max(0.0))),
        "hip" => Box::new(move |x, y| {
            let [u, v] = axes(x, y);
            Some(eaves + slope * (size - u.abs()).min(size - v.abs()).max(0.0))
        }),
        "mansard" => Box::new(move |x, y| {
            let v = (size - axes(x, y)[1].abs()).max(0.0);
            Some(eaves + if v < size / 4.0 { 2.5 * v } else { 0.625 * size + 0.2 * slope * (v - size / 4.0) })
        }),
        "steps" => Box::new(move |x, y| Some(eaves + if axes(x, y)[0] > 0.0 { step } else { 0.0 })),
        "terraces" => Box::new(move |x, y| {
            let [u, v] = axes(x, y);
            Some(eaves + step * ((u / 4.0).floor() + (v / 5.0).floor()).rem_euclid(4.0))
        }),
        "dormers" => Box::new(move |x, y| {
            let [u, v] = axes(x, y);
            let main = eaves + slope * (size - v.abs()).max(0.0);
            let dormer = u.rem_euclid(4.0) < 2.0 && v.abs() > size / 3.0 && v.abs() < size * 0.8;
            Some(if dormer { main.max(eaves + slope * size * 0.6) } else { main })
        }),
        "dome" => {
            Box::new(move |x, y| Some(eaves + (size * size - (x - cx).powi(2) - (y - cy).powi(2)).max(0.0).sqrt()))
        }
        "cone" => Box::new(move |x, y| Some(eaves + slope * (size - (x - cx).hypot(y - cy)).max(0.0))),
        "sawtooth" => Box::new(move |x, y| Some(eaves + slope * axes(x, y)[0].rem_euclid(3.0))),
        "planes" => {
            let planes: Vec<[f64; 3]> = (0..2 + draw.below(12))
                .map(|_| [draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(0.0, 8.0)])
                .collect();
            let lowest = draw.chance(0.5);
            Box::new(move |x, y| {
                let heights = planes.iter().map(|[a, b, c]| a * (x - cx) + b * (y - cy) + c);
                let z = if lowest { heights.fold(f64::MAX, f64::min) } else { heights.fold(f64::MIN, f64::max) };
                Some(eaves + z.clamp(0.0, 40.0))
            })
        }
        "waves" => Box::new(move |x, y| Some(eaves + step * ((x * 1.3).sin() + (y * 1.7).cos()))),
        _ => Box::new(move |_, _| Some(eaves)),
    }
}

fn spoil(points: &mut Vec<Point3<f64>>, ill: &str, [base, eaves]: [f64; 2], draw: &mut Draw) {
    let Some(&first) = points.first() else { return };
    let middle = points[points.len() / 2];
    match ill {
        "half" => points.retain(|p| p.x < middle.x),
        "holes" => {
            let centres: Vec<Point3<f64>> = (0..4).map(|_| points[draw.below(points.len())]).collect();
            let radius = draw.between(0.5, 6.0);
            points.retain(|p| centres.iter().all(|c| (c.xy() - p.xy()).norm() > radius));
        }
        "strays" => {
            for p in points.iter_mut() {
                p.z += if draw.chance(0.05) { draw.between(-30.0, 30.0) } else { 0.0 };
            }
        }
        "duplicates" => {
            let twice: Vec<Point3<f64>> = points.iter().flat_map(|p| [*p; 3]).collect();
            *points = twice;
        }
        "line" => {
            let lean = draw.of(&[0.0, 0.5, 1.0]);
            for p in points.iter_mut() {
                *p = Point3::new(p.x, middle.y, eaves + lean * (p.x - middle.x));
            }
        }
        "three" => points.truncate(3),
        "one" => points.truncate(1),
        "nowhere" => points.clear(),
        "place" => points.iter_mut().for_each(|p| *p = first),
        "walls" => {
            for p in points.iter_mut() {
                *p = Point3::new(middle.x + 0.02 * draw.normal(), p.y, draw.between(base, eaves));
            }
        }
        "noise" => points.iter_mut().for_each(|p| p.z = eaves + 20.0 * draw.unit()),
        "far" => {
            let far = draw.of(&[300.0, -300.0, 1e5]);
            points.iter_mut().step_by(50).for_each(|p| p.z += far);
        }
        "not-numbers" => {
            for p in points.iter_mut() {
                p.z =
                    if draw.chance(0.1) { draw.of(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300]) } else { p.z };
            }
        }
        _ => {}
    }
}
