//! Reference values of the stage, computed in float64 straight from the definitions.

#![allow(clippy::unwrap_used)]

use approx::assert_relative_eq;
use gmpcr_correspondence::{Descriptors, farthest_point_sampling, match_descriptors};
use serde_json::Value;

fn golden() -> Value {
    serde_json::from_str(include_str!("golden/correspondence.json")).unwrap()
}

fn indices(value: &Value) -> Vec<usize> {
    let entries = value.as_array().unwrap().iter();
    entries.map(|k| k.as_u64().unwrap() as usize).collect()
}

fn descriptors(value: &Value) -> Descriptors {
    let rows = value.as_array().unwrap();
    let dimension = rows[0].as_array().unwrap().len();
    let entries = rows.iter().flat_map(|row| row.as_array().unwrap());
    let values = entries.map(|v| v.as_f64().unwrap() as f32).collect();
    Descriptors::new(values, dimension).unwrap()
}

#[test]
fn samples_and_matches_are_the_reference_ones() {
    let golden = golden();
    let num_samples = golden["n_samples"].as_u64().unwrap() as usize;
    let num_matches = golden["n_matches"].as_u64().unwrap() as usize;
    let [i, j] = ["descriptors_i", "descriptors_j"].map(|key| descriptors(&golden[key]));
    let [rows_i, rows_j] = [&i, &j].map(|d| farthest_point_sampling(d, num_samples));
    assert_eq!(rows_i, indices(&golden["sampled_i"]));
    assert_eq!(rows_j, indices(&golden["sampled_j"]));

    let matches = match_descriptors(&i.select(&rows_i), &j.select(&rows_j)).unwrap();
    let expected = golden["matches_all"].as_array().unwrap();
    assert_eq!(matches.len(), expected.len());
    for (m, expected) in matches.iter().zip(expected) {
        assert_eq!(vec![rows_i[m.i], rows_j[m.j]], indices(expected));
    }
    let distances = golden["distances"].as_array().unwrap();
    assert_eq!(distances.len(), num_matches);
    for (m, expected) in matches.iter().zip(distances) {
        // The reference holds decimal descriptors in f64, this crate the nearest f32.
        assert_relative_eq!(m.distance, expected.as_f64().unwrap(), max_relative = 1e-5);
    }
}
