use std::f64::consts::PI;

use super::super::exact;
use super::*;

/// A dark map with a few lamps, the brightest a million times as bright as
/// the sky.
fn night(width: usize, height: usize) -> Vec<[f32; 3]> {
    let mut map: Vec<[f32; 3]> = (0..width * height)
        .map(|i| [1.0, 0.5 + (i % 7) as f32, (i % width) as f32])
        .collect();
    for (place, light) in [(0, 1e3), (width * height / 2 + width / 3, 1e6)] {
        map[place] = [light, 0.0, 0.1 * light];
    }
    map
}

/// The sum over all pairs of texels, with the same weights.
fn by_pairs(table: &Table, map: &[[f32; 3]], width: usize, height: usize) -> Vec<[f64; 3]> {
    let weights = Weights::new(table, width, height);
    let mut row = vec![0.0; width / 2 + 1];
    let mut result = vec![[0.0; 3]; map.len()];
    for at in 0..height {
        for from in 0..height {
            weights.row(at, from, &mut row);
            for here in 0..width {
                for there in 0..width {
                    let columns = here.abs_diff(there);
                    let weight = row[columns.min(width - columns)];
                    for channel in 0..3 {
                        result[at * width + here][channel] +=
                            weight * f64::from(map[from * width + there][channel]);
                    }
                }
            }
        }
    }
    result
}

#[test]
fn transforms_give_the_sum_over_all_pairs_of_texels() {
    for (width, height) in [(1, 1), (1, 3), (2, 1), (16, 8), (13, 9), (30, 17)] {
        let table = Table::new(1.7).unwrap();
        let map = night(width, height);
        let result = spread(&Cpu::new(), &table, &map, width, height).unwrap();
        let expected = by_pairs(&table, &map, width, height);
        for (value, expected) in result.iter().zip(&expected) {
            for channel in 0..3 {
                let error = (f64::from(value[channel]) - expected[channel]).abs();
                // One rounding to f32, and two in weights whose mirror
                // images were rounded another way.
                let bound = 1.8e-7 * expected[channel];
                assert!(error <= bound, "{width} x {height}: {value:?} {expected:?}");
            }
        }
    }
}

/// Shares only N with the implementation: every texel in small parts.
#[test]
fn the_spread_of_one_lamp_is_the_integral_over_its_texel() {
    let (width, height, t) = (24, 12, 0.8);
    let (row, column) = (4, 5);
    let mut map = vec![[0.0; 3]; width * height];
    map[row * width + column] = [1.0, 2.0, 3.0];
    let table = Table::new(t).unwrap();
    let result = spread(&Cpu::new(), &table, &map, width, height).unwrap();
    let step = PI / height as f64;
    let direction = |polar: f64, longitude: f64| {
        [
            polar.sin() * longitude.cos(),
            polar.cos(),
            polar.sin() * longitude.sin(),
        ]
    };
    for (index, value) in result.iter().enumerate() {
        let here = [(index / width) as f64 + 0.5, (index % width) as f64 + 0.5];
        if index == row * width + column {
            continue;
        }
        let eye = direction(here[0] * step, here[1] * step);
        let parts = 60;
        let mut expected = 0.0;
        for i in 0..parts {
            for j in 0..parts {
                let at = |first: usize, part: u32| {
                    (first as f64 + (f64::from(part) + 0.5) / f64::from(parts)) * step
                };
                let polar = at(row, i);
                let lamp = direction(polar, at(column, j));
                let cos: f64 = eye.iter().zip(lamp).map(|(a, b)| a * b).sum();
                let area = (step / f64::from(parts)).powi(2) * polar.sin();
                expected += area * exact::value(t.into(), cos.acos());
            }
        }
        // Midpoints of parts that are 1/30 of their distance or less: 1e-4,
        // and the 1.5e-4 of the weights.
        for (channel, factor) in [1.0, 2.0, 3.0].into_iter().enumerate() {
            let error = f64::from(value[channel]) / (factor * expected) - 1.0;
            assert!(error.abs() < 2.5e-4, "texel {index}: {error:e}");
        }
    }
}

#[test]
fn an_even_environment_stays_even() {
    for t in [0.0, 0.3, 5.0, 60.0] {
        let table = Table::new(t).unwrap();
        let result = spread(&Cpu::new(), &table, &[[2.0; 3]; 64 * 32], 64, 32).unwrap();
        let expected = 2.0 * exact::total(t.into());
        for value in result.iter().flatten() {
            assert!((f64::from(*value) / expected - 1.0).abs() < 1e-4, "T {t}");
        }
    }
}

/// What a lamp loses to the fog's halo is found in the halo.
#[test]
fn the_halo_of_a_lamp_has_the_total_of_the_spread() {
    let (width, height) = (128, 64);
    let step = PI / 64.0;
    for row in [2, 20, 40] {
        let mut map = vec![[0.0; 3]; width * height];
        map[row * width + 9] = [1.0; 3];
        let table = Table::new(1.0).unwrap();
        let result = spread(&Cpu::new(), &table, &map, width, height).unwrap();
        let area = |row: usize| 2.0 * (0.5 * step).sin() * step * ((row as f64 + 0.5) * step).sin();
        let halo: f64 = result
            .iter()
            .enumerate()
            .map(|(index, value)| area(index / width) * f64::from(value[0]))
            .sum();
        let expected = area(row) * exact::total(1.0);
        // N is sampled at centres here: the peak, 1/4γ over one texel, is
        // not resolved, and adds an error of the order of the texel.
        assert!((halo / expected - 1.0).abs() < step, "row {row}");
    }
}

#[test]
fn fog_dims_and_spreads_each_channel_by_itself() {
    let fog = Fog::new([0.0, 0.7, 0.7], [1.0, 0.9, 0.0]).unwrap();
    let map = night(16, 8);
    let seen = through_fog(&Cpu::new(), &fog, &map, 16, 8).unwrap();
    let table = Table::new(0.7).unwrap();
    let blurred = spread(&Cpu::new(), &table, &map, 16, 8).unwrap();
    let dim = (-0.7_f32).exp();
    for ((seen, clear), blurred) in seen.iter().zip(&map).zip(&blurred) {
        assert_eq!(seen[0], clear[0], "no fog");
        let green = dim * (clear[1] + 0.9 * 0.7 * blurred[1]);
        assert!((seen[1] - green).abs() <= 3e-7 * green);
        let blue = dim * clear[2];
        assert!((seen[2] - blue).abs() <= 3e-7 * blue, "black fog");
    }
}

#[test]
fn the_largest_numbers_give_no_nan() {
    let map = [[f32::MAX, f32::MAX, f32::MIN]; 8];
    for t in [0.0, 1.0, 300.0, f32::MAX] {
        for albedo in [0.0, 1.0] {
            let fog = Fog::new([t, t, 1.0], [albedo, 0.0, 1.0]).unwrap();
            let seen = through_fog(&Cpu::new(), &fog, &map, 4, 2).unwrap();
            assert!(seen.iter().flatten().all(|value| !value.is_nan()));
        }
    }
}

#[test]
fn threads_change_nothing() {
    let table = Table::new(2.0).unwrap();
    let map = night(32, 17);
    let alone = spread(&Cpu::single_threaded(), &table, &map, 32, 17).unwrap();
    assert_eq!(alone, spread(&Cpu::new(), &table, &map, 32, 17).unwrap());
}

#[test]
fn maps_and_fogs_that_are_none_are_refused() {
    let cpu = Cpu::single_threaded();
    let table = Table::new(1.0).unwrap();
    let fails = |map: &[[f32; 3]], width, height, what: &str| {
        let error = spread(&cpu, &table, map, width, height).unwrap_err();
        assert!(error.to_string().contains(what), "{error}");
    };
    fails(&[], 0, 0, "number of texels");
    fails(&[[1.0; 3]; 6], 4, 2, "number of texels");
    fails(&[[1.0; 3]; 6], usize::MAX, 2, "number of texels");
    fails(&[[1.0; 3]; 5], 1, 5, "the width");
    fails(&[[1.0, f32::NAN, 0.0]], 1, 1, "a texel");
    fails(&[[1.0, f32::INFINITY, 0.0]], 1, 1, "a texel");
    for (t, albedo) in [
        (-1.0, 0.5),
        (f32::INFINITY, 0.5),
        (1.0, 1.1),
        (1.0, f32::NAN),
    ] {
        assert!(Fog::new([1.0, t, 1.0], [0.5, albedo, 0.5]).is_err());
    }
}
