use std::time::Duration;

use glam::{DQuat, DVec3};
use gpu_backend::Cpu;
use proptest::prelude::*;

use super::bake::threads;
use super::mesh::{Solid, Soup, lights, solid};
use crate::{Builder, Error, KeptGrid, Mesh, Rule};

fn whole(builder: Builder, mesh: &Mesh) -> Vec<u8> {
    builder.bake(&Cpu::new(), mesh).unwrap().into_bytes()
}

proptest! {
    #![proptest_config(reference::property::cases(40))]

    #[test]
    fn a_grid_that_followed_any_moves_has_the_bytes_of_a_fresh_bake(
        solids in proptest::collection::vec(solid(), 1..12),
        steps in proptest::collection::vec(
            (
                any::<prop::sample::Index>(),
                (-0.3_f64..0.3, -0.3_f64..0.3, -0.3_f64..0.3),
                0..6,
                1_usize..4,
            ),
            1..6,
        ),
        light in proptest::sample::select(lights().to_vec()),
        rule in proptest::sample::select(vec![Rule::Aligned, Rule::Aligned, Rule::Kampe2015]),
        side in proptest::sample::select(&[64, 256][..]),
    ) {
        let builder = Builder::new().rule(rule);
        let mut solids = solids;
        let mesh = |solids: &[Solid]| Soup::of(solids).mesh(side, light);
        let mut kept = KeptGrid::new(&Cpu::new(), builder, &mesh(&solids)).unwrap();
        for (which, by, kind, number) in steps {
            let at = which.index(solids.len().max(1));
            match kind {
                // One comes, one goes, one appears where another one is.
                0 => solids.push(Solid {
                    centre: by.into(),
                    half: DVec3::splat(0.1),
                    turn: DQuat::from_rotation_z(by.0),
                }),
                1 if at < solids.len() => drop(solids.remove(at)),
                2 if at < solids.len() => solids.push(solids[at]),
                _ if at < solids.len() => solids[at].centre += DVec3::from(by),
                _ => {}
            }
            let mesh = mesh(&solids);
            let before = kept.grid().as_bytes().to_vec();
            // One that is dropped leaves the old grid.
            let mut dropped = kept.rebuild(mesh.clone());
            dropped.advance(&Cpu::new(), Duration::ZERO).unwrap();
            drop(dropped);
            let cpu = threads(number);
            let mut rebuild = kept.rebuild(mesh.clone());
            let mut last = rebuild.progress();
            while !last.is_complete() {
                let now = rebuild.advance(&cpu, Duration::from_micros(50)).unwrap();
                prop_assert!(now.finished > last.finished);
                last = now;
            }
            prop_assert!(kept.grid().as_bytes() == before);
            kept.replace(rebuild).unwrap();
            prop_assert!(kept.grid().as_bytes() == whole(builder, &mesh));
        }
    }
}

/// Small cubes on a floor, one of which has moved by `x`.
fn street(x: f64) -> Soup {
    let cube = |x: f64, y: f64| Solid {
        centre: DVec3::new(x, y, 0.0),
        half: DVec3::splat(0.02),
        turn: DQuat::IDENTITY,
    };
    let mut solids: Vec<Solid> = (0..64)
        .map(|i| cube(0.1 * f64::from(i % 8) - 0.35, 0.1 * f64::from(i / 8) - 0.35))
        .collect();
    solids[27].centre.x += x;
    solids.push(Solid {
        centre: DVec3::new(0.0, 0.0, -0.2),
        half: DVec3::new(0.49, 0.49, 0.05),
        turn: DQuat::IDENTITY,
    });
    Soup::of(&solids)
}

#[test]
fn only_tiles_under_what_moved_are_made_again() {
    let light = lights()[1];
    let (cpu, builder) = (Cpu::new(), Builder::new());
    let mut kept = KeptGrid::new(&cpu, builder, &street(0.0).mesh(512, light)).unwrap();
    let same = kept.rebuild(street(0.0).mesh(512, light)).progress();
    assert_eq!((same.finished, same.tiles), (0, 0));
    // A cube takes 4 × 4 tiles at most, where it was and where it is.
    let moved = street(0.03).mesh(512, light);
    let mut rebuild = kept.rebuild(moved.clone());
    let tiles = rebuild.progress().tiles;
    assert!((4..=32).contains(&tiles), "{tiles}");

    let early = kept.replace(kept.rebuild(moved.clone())).unwrap_err();
    assert!(
        matches!(early, Error::Cancelled { finished: 0, .. }),
        "{early}"
    );
    let mut late = kept.rebuild(moved.clone());
    for rebuild in [&mut rebuild, &mut late] {
        assert!(rebuild.advance(&cpu, Duration::MAX).unwrap().is_complete());
    }
    kept.replace(rebuild).unwrap();
    assert!(kept.grid().as_bytes() == whole(builder, &moved));
    assert!(matches!(kept.replace(late), Err(Error::Outdated)));
    assert!(kept.grid().as_bytes() == whole(builder, &moved));
}

#[test]
fn another_light_or_resolution_is_made_as_a_whole() {
    let (cpu, builder) = (Cpu::new(), Builder::new());
    let [a, b, ..] = lights();
    let mut kept = KeptGrid::new(&cpu, builder, &street(0.0).mesh(512, a)).unwrap();
    for (side, light) in [(512, b), (1024, b), (64, a)] {
        let mesh = street(0.0).mesh(side, light);
        let mut rebuild = kept.rebuild(mesh.clone());
        rebuild.advance(&cpu, Duration::MAX).unwrap();
        kept.replace(rebuild).unwrap();
        assert!(kept.grid().as_bytes() == whole(builder, &mesh));
    }
}

#[test]
fn what_no_tile_needs_any_more_does_not_add_up() {
    let light = lights()[0];
    let (cpu, builder) = (Cpu::new(), Builder::new());
    let mut kept = KeptGrid::new(&cpu, builder, &street(0.0).mesh(256, light)).unwrap();
    let first = kept.nodes();
    for step in 0..40 {
        let mesh = street(0.001 * f64::from(step)).mesh(256, light);
        let mut rebuild = kept.rebuild(mesh.clone());
        rebuild.advance(&cpu, Duration::MAX).unwrap();
        kept.replace(rebuild).unwrap();
        assert!(kept.nodes() < 4 * first, "{step}: {}", kept.nodes());
        assert!(kept.grid().as_bytes() == whole(builder, &mesh));
    }
}
