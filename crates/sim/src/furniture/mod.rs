//! Furniture, every piece with sizes and contents of its own.
//!
//! A piece stands on z = 0. Pieces that belong against a wall have their back at y = 0 and face
//! towards y > 0.

mod bed;
mod clutter;
mod kitchen;
mod light;
mod piece;
mod plant;
mod seat;
mod storage;
mod table;
mod tabletop;

pub(crate) use clutter::floor_clutter;
pub(crate) use piece::Piece;
pub(crate) use tabletop::tabletop_items;

use rand_chacha::ChaCha8Rng;

/// Draws one piece.
pub(crate) type Maker = fn(&mut ChaCha8Rng) -> Piece;

/// What stands along the walls of a room.
pub(crate) const ALONG_WALLS: [Maker; 14] = [
    storage::bookshelf,
    storage::bookshelf,
    storage::cabinet,
    storage::wardrobe,
    storage::sideboard,
    seat::sofa,
    seat::armchair,
    table::desk,
    kitchen::counter,
    bed::bed,
    plant::plant,
    light::floor_lamp,
    clutter::box_pile,
    kitchen::radiator,
];

/// What stands in the middle of a room.
pub(crate) const FREE_STANDING: [Maker; 6] = [
    table::dining_group,
    table::coffee_table,
    seat::armchair,
    seat::chair,
    plant::plant,
    clutter::box_pile,
];
