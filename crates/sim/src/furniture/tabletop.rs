//! Small things on tables, shelves and boards.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::piece::Piece;
use crate::random::{chance, count, uniform};

/// About `number` things on a surface z = 0 of `width` (around x = 0) and `depth` (from y = 0),
/// side by side and each rotated at random.
pub(crate) fn tabletop_items(width: f64, depth: f64, number: usize, rng: &mut ChaCha8Rng) -> Piece {
    let mut items = Piece::default();
    let cell = width / number.max(1) as f64;
    let reach = cell.min(depth).min(0.4);
    for k in 0..number {
        let x = -width / 2.0 + (k as f64 + uniform(rng, 0.35, 0.65)) * cell;
        let y = depth * uniform(rng, 0.35, 0.65);
        let angle = uniform(rng, 0.0, std::f64::consts::TAU);
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        let place = Isometry3::from_parts(Translation3::new(x, y, 0.0), rotation);
        items.put(item(reach, rng), &place);
    }
    items
}

/// One thing that fits into a circle of diameter `reach` or not much more.
fn item(reach: f64, rng: &mut ChaCha8Rng) -> Piece {
    match count(rng, 0, 7) {
        0 => mug(rng),
        1 => bottle(rng),
        2 => bowl(reach, rng),
        3 | 4 => book_stack(reach, rng),
        5 => carton(reach, rng),
        6 => small_plant(rng),
        _ => table_lamp(rng),
    }
}

fn mug(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let (radius, height) = (uniform(rng, 0.035, 0.06), uniform(rng, 0.08, 0.15));
    piece.post([0.0, 0.0, 0.0], radius, height);
    piece.block(
        [radius + 0.015, 0.0, height / 2.0],
        [0.03, 0.015, 0.6 * height],
    );
    piece
}

fn bottle(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let (radius, height) = (uniform(rng, 0.03, 0.06), uniform(rng, 0.14, 0.25));
    piece.post([0.0, 0.0, 0.0], radius, height);
    piece.ball([0.0, 0.0, height], radius);
    piece.post([0.0, 0.0, height], 0.4 * radius, uniform(rng, 0.07, 0.14));
    piece
}

/// Fruit heaped on a dish.
fn bowl(reach: f64, rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let radius = (0.45 * reach).min(uniform(rng, 0.09, 0.17));
    piece.post([0.0, 0.0, 0.0], 0.6 * radius, 0.03);
    piece.post([0.0, 0.0, 0.03], radius, 0.03);
    for _ in 0..count(rng, 2, 6) {
        let offset = [(); 2].map(|()| uniform(rng, -0.6, 0.6) * radius);
        piece.ball([offset[0], offset[1], 0.08], uniform(rng, 0.03, 0.06));
    }
    piece
}

fn book_stack(reach: f64, rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let mut z = 0.0;
    for _ in 0..count(rng, 1, 5) {
        let thickness = uniform(rng, 0.02, 0.06);
        let size = [0.7 * reach, 0.5 * reach].map(|side| side * uniform(rng, 0.7, 1.1));
        let angle = uniform(rng, -0.5, 0.5);
        piece.rotated_block(
            [0.0, 0.0, z + thickness / 2.0],
            [size[0], size[1], thickness],
            angle,
        );
        z += thickness;
    }
    piece
}

fn carton(reach: f64, rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let size = [(); 3].map(|()| reach.min(0.35) * uniform(rng, 0.35, 0.8));
    piece.block([0.0, 0.0, size[2] / 2.0], size);
    if chance(rng, 0.5) {
        let lid = [size[0] * 1.08, size[1] * 1.08, 0.03];
        piece.block([0.0, 0.0, size[2]], lid);
    }
    piece
}

fn small_plant(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let height = uniform(rng, 0.08, 0.14);
    piece.post([0.0, 0.0, 0.0], uniform(rng, 0.05, 0.08), height);
    for _ in 0..count(rng, 3, 6) {
        let offset = [(); 2].map(|()| uniform(rng, -0.08, 0.08));
        let center = [offset[0], offset[1], height + uniform(rng, 0.03, 0.18)];
        piece.ball(center, uniform(rng, 0.03, 0.07));
    }
    piece
}

fn table_lamp(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let lean = uniform(rng, -0.12, 0.12);
    let height = uniform(rng, 0.25, 0.45);
    piece.post([0.0, 0.0, 0.0], uniform(rng, 0.06, 0.1), 0.025);
    piece.bar(Point3::origin(), Point3::new(lean, 0.0, height), 0.012);
    if chance(rng, 0.5) {
        piece.ball([lean, 0.0, height], uniform(rng, 0.07, 0.12));
    } else {
        piece.post(
            [lean, 0.0, height - 0.1],
            uniform(rng, 0.08, 0.14),
            uniform(rng, 0.12, 0.2),
        );
    }
    piece
}
