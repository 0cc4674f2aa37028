use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use glam::Vec3;

use super::*;
use crate::{Emitter, Falloff, Light, PhaseFunction};

fn with_nodes(nodes: &str, rest: &str) -> Result<Loaded, LoadError> {
    let (draft, mesh) = tetrahedron();
    draft.load(&format!(
        r#"{mesh},"nodes":[{{"mesh":0}},{nodes}],"scenes":[{{"nodes":[0,1]}}]{rest}"#
    ))
}

fn with_light(node: &str, light: &str) -> Result<Loaded, LoadError> {
    with_nodes(
        &format!(r#"{{{node}"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}"#),
        &format!(r#","extensions":{{"KHR_lights_punctual":{{"lights":[{light}]}}}}"#),
    )
}

/// Looks along +X and is scaled without mercy.
const TURNED: &str =
    r#""translation":[1,2,3],"rotation":[0,-0.70710678,0,0.70710678],"scale":[5,0.1,9],"#;

#[test]
fn punctual_lights_are_taken_as_they_are() {
    let loaded = with_light(
        TURNED,
        r#"{"type":"spot","color":[1,0.5,0.25],"intensity":40,"range":12,"spot":{"innerConeAngle":0.3,"outerConeAngle":0.7}}"#,
    )
    .unwrap();
    let [Light::Spot(spot)] = &loaded.scene.lights[..] else {
        panic!("{:?}", loaded.scene.lights);
    };
    assert_eq!(spot.position, Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(spot.intensity, Vec3::new(40.0, 20.0, 10.0));
    assert_eq!(
        (spot.range, spot.cone.inner, spot.cone.outer),
        (12.0, 0.3, 0.7)
    );
    assert!((spot.rotation * Vec3::NEG_Z - Vec3::X).length() < 1e-6);
    assert!((spot.rotation * Vec3::Y - Vec3::Y).length() < 1e-6);

    let loaded = with_light(TURNED, r#"{"type":"directional","intensity":3}"#).unwrap();
    let [Light::Directional(sun)] = &loaded.scene.lights[..] else {
        panic!("{:?}", loaded.scene.lights);
    };
    assert!((sun.direction - Vec3::X).length() < 1e-6);
    assert_eq!(sun.irradiance, Vec3::splat(3.0));

    let loaded = with_light(TURNED, r#"{"type":"point"}"#).unwrap();
    let [Light::Point(point)] = &loaded.scene.lights[..] else {
        panic!("{:?}", loaded.scene.lights);
    };
    assert_eq!((point.intensity, point.range), (Vec3::ONE, f32::INFINITY));
}

#[test]
fn a_mirrored_light_looks_where_its_node_looks() {
    let node = format!(
        r#""matrix":[-1,0,0,0, 0,{h},{h},0, 0,-{h},{h},0, 0,0,0,1],"#,
        h = FRAC_1_SQRT_2
    );
    let loaded = with_light(&node, r#"{"type":"spot","spot":{}}"#).unwrap();
    let [Light::Spot(spot)] = &loaded.scene.lights[..] else {
        panic!("{:?}", loaded.scene.lights);
    };
    let expected = Vec3::new(0.0, FRAC_1_SQRT_2, -FRAC_1_SQRT_2);
    assert!((spot.rotation * Vec3::NEG_Z - expected).length() < 1e-6);
    assert!((spot.rotation.length() - 1.0).abs() < 1e-6);
    assert_eq!(spot.cone.inner, 0.0);
}

#[test]
fn lights_at_the_border_of_the_specification_still_load() {
    let widest = format!(r#"{{"type":"spot","spot":{{"outerConeAngle":{FRAC_PI_2}}}}}"#);
    assert_eq!(with_light("", &widest).unwrap().scene.lights.len(), 1);
    let hard = r#"{"type":"spot","spot":{"innerConeAngle":0.5,"outerConeAngle":0.5}}"#;
    let loaded = with_light("", hard).unwrap();
    assert!(loaded.scene.lights[0].emitters(1).is_ok());
    assert!(loaded.notes[0].contains("softer"), "{:?}", loaded.notes);
    let flat = with_light(r#""scale":[0,0,0],"#, r#"{"type":"directional"}"#).unwrap();
    assert!(flat.scene.lights.is_empty());
    assert!(
        flat.notes[0].contains("scaled to nothing"),
        "{:?}",
        flat.notes
    );
}

#[test]
fn bad_lights_are_refused_with_their_cause() {
    for (light, cause) in [
        (r#"{"type":"moon"}"#, "directional, point or spot"),
        (r#"{"type":"spot"}"#, "spot"),
        (r#"{"type":"point","intensity":-1}"#, "intensity"),
        (r#"{"type":"point","intensity":1e99}"#, "intensity"),
        (r#"{"type":"point","name":"lamp","range":-1}"#, "\"lamp\""),
        (r#"{"type":"spot","spot":{"innerConeAngle":0.9}}"#, "cone"),
        (r#"{"type":"spot","spot":{"outerConeAngle":2}}"#, "cone"),
        ("", "light index 0"),
    ] {
        let error = with_light("", light).unwrap_err().to_string();
        assert!(error.contains(cause), "{light}: {error}");
    }
}

#[test]
fn light_fades_towards_a_range_unless_the_extras_say_hard() {
    for kind in [r#""type":"point""#, r#""type":"spot","spot":{}"#] {
        for (extras, expected) in [
            ("", Falloff::Smooth),
            (r#","extras":{"falloff":"smooth"}"#, Falloff::Smooth),
            (r#","extras":{"falloff":"hard"}"#, Falloff::Hard),
        ] {
            let loaded = with_light("", &format!(r#"{{{kind},"range":5{extras}}}"#)).unwrap();
            let emitters = loaded.scene.lights[0].emitters(1).unwrap();
            let Emitter::Point(point) = &emitters[0] else {
                panic!("{emitters:?}");
            };
            assert_eq!(point.falloff(), expected, "{kind} {extras}");
            let half = if expected == Falloff::Hard {
                1.0
            } else {
                15.0 / 16.0
            };
            assert_eq!([2.5, 5.01].map(|d| point.window(d)), [half, 0.0]);
        }
    }
    let bad = r#"{"type":"point","range":5,"extras":{"falloff":3}}"#;
    let error = with_light("", bad).unwrap_err().to_string();
    assert!(error.contains("falloff"), "{error}");
}

#[test]
fn a_range_of_zero_is_no_limit() {
    let loaded = with_light("", r#"{"type":"point","range":0}"#).unwrap();
    let [Light::Point(point)] = &loaded.scene.lights[..] else {
        panic!("{:?}", loaded.scene.lights);
    };
    assert_eq!(point.range, f32::INFINITY);
    assert!(loaded.notes[0].contains("no limit"), "{:?}", loaded.notes);
}

#[test]
fn lights_are_called_like_themselves_or_like_their_nodes() {
    for (node, light, name) in [
        ("", r#"{"type":"point","name":"lamp"}"#, "lamp"),
        (
            r#""name":"pole","#,
            r#"{"type":"point","name":"lamp"}"#,
            "lamp",
        ),
        (r#""name":"pole","#, r#"{"type":"spot","spot":{}}"#, "pole"),
        (
            r#""name":"pole","#,
            r#"{"type":"directional","name":""}"#,
            "pole",
        ),
        ("", r#"{"type":"point"}"#, ""),
    ] {
        let loaded = with_light(node, light).unwrap();
        assert_eq!(loaded.scene.lights[0].name(), name);
    }
}

#[test]
fn extras_give_a_sun_its_disk() {
    for (node, extras) in [
        ("", r#","extras":{"angularDiameter":0.0093}"#),
        (r#""extras":{"angularDiameter":0.0093},"#, ""),
        (
            r#""extras":{"angularDiameter":0.5},"#,
            r#","extras":{"angularDiameter":0.0093}"#,
        ),
    ] {
        let light = format!(r#"{{"type":"directional"{extras}}}"#);
        let loaded = with_light(node, &light).unwrap();
        let [Light::Directional(sun)] = &loaded.scene.lights[..] else {
            panic!("{:?}", loaded.scene.lights);
        };
        assert_eq!(sun.angular_diameter, 0.0093);
        assert_eq!(loaded.scene.lights[0].emitters(7).unwrap().len(), 7);
    }
    for bad in ["-1", "2", "\"secret\""] {
        let light = format!(r#"{{"type":"directional","extras":{{"angularDiameter":{bad}}}}}"#);
        let error = with_light("", &light).unwrap_err().to_string();
        assert!(
            error.contains("angularDiameter") && !error.contains("secret"),
            "{error}"
        );
    }
}

/// A spotlight with this cookie and an image of 2 × 1 texels, black and white.
fn with_cookie(cookie: &str, spot: &str) -> Result<Loaded, LoadError> {
    let mut png = std::io::Cursor::new(Vec::new());
    let image = image::GrayImage::from_raw(2, 1, vec![0, 255]).unwrap();
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let (mut draft, mesh) = tetrahedron();
    let view = draft.view(&png.into_inner(), "");
    draft.load(&format!(
        r#"{mesh},"nodes":[{{"mesh":0}},{{"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],"images":[{{"bufferView":{view}}},{{"uri":"data:,x"}}],"extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"spot","spot":{spot},"extras":{{"cookie":{cookie}}}}}]}}}}"#
    ))
}

#[test]
fn extras_put_a_cookie_in_front_of_a_spotlight() {
    let right = |rotation: &str| {
        let cookie = format!(r#"{{"image":0{rotation}}}"#);
        let loaded = with_cookie(&cookie, "{}").unwrap();
        let emitters = loaded.scene.lights[0].emitters(1).unwrap();
        let crate::Emitter::Point(point) = emitters[0].clone() else {
            panic!("a spotlight is near");
        };
        let to = |x: f32, y: f32| point.emission().factor(Vec3::new(x, y, -1.0).normalize()).x;
        [to(0.4, 0.0), to(-0.4, 0.0), to(0.0, 0.4), to(0.0, -0.4)].map(|f| (10.0 * f) as u32)
    };
    let [full, none] = [right("")[0], 0];
    assert!(full > 1);
    assert_eq!(right("")[1], none, "white is on the right");
    let quarter = right(r#","rotation":1.5707963"#);
    assert_eq!((quarter[2], quarter[3]), (full, none), "turned to the top");
    let notes = with_cookie(r#"{"image":1}"#, "{}")
        .unwrap()
        .notes
        .join("\n");
    assert!(notes.contains("cookie of light 0 left out"), "{notes}");
    for (cookie, spot, cause) in [
        (r#"{"image":7}"#, "{}", "image index 7"),
        (r#"{"image":"secret"}"#, "{}", "the index of an image"),
        (r#"{"image":0,"rotation":"secret"}"#, "{}", "radians"),
        ("3", "{}", "the index of an image"),
        (r#"{"image":0}"#, r#"{"outerConeAngle":1.55}"#, "1.5 rad"),
    ] {
        let error = with_cookie(cookie, spot).unwrap_err().to_string();
        assert!(
            error.contains(cause) && !error.contains("secret"),
            "{error}"
        );
    }
}

fn with_area_light(node: &str, light: &str) -> Result<Loaded, LoadError> {
    with_nodes(
        &format!(r#"{{{node}"extensions":{{"EXT_lights_area":{{"light":0}}}}}}"#),
        &format!(
            r#","extensionsRequired":["EXT_lights_area"],"extensions":{{"EXT_lights_area":{{"lights":[{light}]}}}}"#
        ),
    )
}

#[test]
fn area_lights_shine_along_minus_z_and_take_the_largest_scale() {
    let rect = r#"{"type":"rect","name":"panel","size":0.5,"intensity":20,"color":[1,0.5,0],"rect":{"aspect":3}}"#;
    let node = r#""translation":[1,2,3],"scale":[1,-4,2],"#;
    let loaded = with_area_light(node, rect).unwrap();
    let [Light::Area(light)] = &loaded.scene.lights[..] else {
        panic!("{:?}", loaded.scene.lights);
    };
    assert_eq!(
        (light.name.as_str(), light.shape),
        ("panel", crate::AreaShape::Rectangle)
    );
    let [u, v] = light.edges;
    assert!((u.length() - 6.0).abs() < 1e-5 && (v.length() - 2.0).abs() < 1e-5);
    assert!((light.corner + 0.5 * (u + v) - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-5);
    assert_eq!(light.radiance, Vec3::new(20.0, 10.0, 0.0));
    let loaded = with_area_light("", rect).unwrap();
    let [Light::Area(light)] = &loaded.scene.lights[..] else {
        panic!("{:?}", loaded.scene.lights);
    };
    let front = light.edges[0].cross(light.edges[1]);
    assert!((front.normalize() - Vec3::NEG_Z).length() < 1e-6, "{front}");
    let disk = with_area_light("", r#"{"type":"disk"}"#).unwrap();
    let [Light::Area(light)] = &disk.scene.lights[..] else {
        panic!("{:?}", disk.scene.lights);
    };
    assert_eq!(
        (light.shape, light.radiance),
        (crate::AreaShape::Disk, Vec3::splat(1000.0))
    );
    let flat = with_area_light(r#""scale":[0,0,0],"#, rect).unwrap();
    assert!(flat.scene.lights.is_empty() && flat.notes[0].contains("no area"));
    for (light, cause) in [
        (r#"{"type":"secret"}"#, "rect or disk"),
        ("{}", "rect or disk"),
        (r#"{"type":"disk","size":-1}"#, "size of area light 0"),
        (r#"{"type":"disk","intensity":"secret"}"#, "intensity"),
        (r#"{"type":"rect","rect":{"aspect":-1}}"#, "aspect"),
        (r#"{"type":"disk","color":[1,2]}"#, "color"),
        ("", "area light index 0"),
    ] {
        let error = with_area_light("", light).unwrap_err().to_string();
        assert!(
            error.contains(cause) && !error.contains("secret"),
            "{light}: {error}"
        );
    }
}

#[test]
fn the_first_perspective_camera_is_the_camera() {
    let cameras = r#","cameras":[{"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"zfar":9,"znear":1}},{"type":"perspective","perspective":{"yfov":0.9,"znear":0.1}}]"#;
    let loaded = with_nodes(
        r#"{"camera":0,"children":[2,3]},{"camera":1,"translation":[0,1,0],"scale":[3,3,3],"rotation":[0,1,0,0]},{"camera":1}"#,
        cameras,
    )
    .unwrap();
    let camera = loaded.scene.camera.unwrap();
    assert_eq!((camera.eye(), camera.vertical_fov()), (Vec3::Y, 0.9));
    assert!((camera.direction(0.5, 0.5, 1, 1) - Vec3::Z).length() < 1e-6);
    let notes = loaded.notes.join("\n");
    assert!(
        notes.contains("first perspective camera") && notes.contains("the first camera"),
        "{notes}"
    );

    let wide = cameras.replace("0.9", "3.2");
    let error = with_nodes(r#"{"camera":1}"#, &wide)
        .unwrap_err()
        .to_string();
    assert!(error.contains("field of view"), "{error}");
    let lying = r#","cameras":[{"type":"perspective"}]"#;
    assert!(
        with_nodes(r#"{"camera":0}"#, lying)
            .unwrap()
            .scene
            .camera
            .is_none()
    );
}

#[test]
fn a_perspective_camera_stands_for_an_orthographic_one() {
    let camera = |ymag: &str| {
        let cameras = format!(
            r#","cameras":[{{"type":"orthographic","orthographic":{{"xmag":9,"ymag":{ymag},"zfar":99,"znear":1}}}}]"#
        );
        // The tetrahedron is in the middle of z = 0 to 1, seen from above z = 5.
        with_nodes(
            r#"{"camera":0,"translation":[0.5,0,5],"scale":[1,1,7]}"#,
            &cameras,
        )
    };
    let loaded = camera("2").unwrap();
    let camera_of = loaded.scene.camera.unwrap();
    let (eye, fov) = (camera_of.eye(), camera_of.vertical_fov());
    assert_eq!((eye.x, eye.y), (0.5, 0.0));
    // Half the frame's height where the middle of the scene is.
    let half = (eye.z - 0.5) * (0.5 * fov).tan();
    assert!((half - 2.0).abs() < 1e-5, "{half}");
    let notes = loaded.notes.join("\n");
    assert!(notes.contains("camera 0 is orthographic"), "{notes}");
    for bad in ["0", "-1"] {
        let error = camera(bad).unwrap_err().to_string();
        assert!(error.contains("ymag of camera 0"), "{error}");
    }
}

fn with_extras(medium: &str) -> Result<Loaded, LoadError> {
    with_nodes(
        "{}",
        &format!(r#","extras":{{"other":1,"medium":{medium}}}"#),
    )
}

#[test]
fn the_medium_comes_from_the_extras() {
    let medium = with_extras(
        r#"{"sigma_s":[0.1,0.2,0.3],"sigma_a":0.5,"phase":"henyey-greenstein","g":-0.3,"box":[[-1,0,-1],[1,2,1]]}"#,
    );
    let medium = medium.unwrap().scene.medium.unwrap();
    assert_eq!(medium.sigma_s(), Vec3::new(0.1, 0.2, 0.3));
    assert_eq!(medium.sigma_a(), Vec3::splat(0.5));
    assert_eq!(medium.phase(), PhaseFunction::HenyeyGreenstein { g: -0.3 });
    assert_eq!(medium.bounds().unwrap().max(), Vec3::new(1.0, 2.0, 1.0));
    for (extras, phase) in [
        (
            r#"{"sigma_s":1,"phase":"cornette-shanks","g":0.5}"#,
            PhaseFunction::CornetteShanks { g: 0.5 },
        ),
        (
            r#"{"sigma_s":1,"phase":"schlick","k":-0.5}"#,
            PhaseFunction::Schlick { k: -0.5 },
        ),
        (
            r#"{"sigma_s":1,"phase":"double-henyey-greenstein","g":[0.8,-0.3],"weight":0.75}"#,
            PhaseFunction::DoubleHenyeyGreenstein {
                g: [0.8, -0.3],
                weight: 0.75,
            },
        ),
        (
            r#"{"sigma_s":1,"phase":"droplets","diameter":12}"#,
            PhaseFunction::droplets(12.0).unwrap(),
        ),
    ] {
        let medium = with_extras(extras).unwrap().scene.medium.unwrap();
        assert_eq!(medium.phase(), phase);
    }
    let medium = with_extras(r#"{"sigma_s":1,"phase":"rayleigh"}"#)
        .unwrap()
        .scene
        .medium
        .unwrap();
    assert_eq!(medium.phase(), PhaseFunction::Rayleigh);
    assert!(medium.bounds().is_none() && medium.sigma_a() == Vec3::ZERO);
    assert!(
        with_nodes("{}", r#","extras":[1]"#)
            .unwrap()
            .scene
            .medium
            .is_none()
    );
}

#[test]
fn fog_that_thins_out_comes_from_the_extras() {
    let with = |fog: &str| with_nodes("{}", &format!(r#","extras":{{"heightFog":{fog}}}"#));
    let fog = r#"{"sigma_s":[0.1,0.2,0.3],"scaleHeight":12,"altitude":-2,"phase":"rayleigh"}"#;
    let scene = with(fog).unwrap().scene;
    let fog = scene.height_fog.unwrap();
    assert!(scene.medium.is_none());
    assert_eq!(fog.sigma_s(), Vec3::new(0.1, 0.2, 0.3));
    assert_eq!((fog.altitude(), fog.scale_height()), (-2.0, 12.0));
    assert_eq!(fog.phase(), PhaseFunction::Rayleigh);
    for (bad, of) in [
        (r#"{"sigma_s":1}"#, "heightFog.scaleHeight"),
        (r#"{"scaleHeight":1}"#, "sigma_s or sigma_a"),
        (
            r#"{"sigma_s":1,"scaleHeight":"x"}"#,
            "heightFog.scaleHeight",
        ),
        (r#"{"sigma_s":1,"scaleHeight":1,"box":0}"#, "heightFog"),
        (r#"{"sigma_s":-1,"scaleHeight":1}"#, "heightFog.sigma_s"),
        ("3", "heightFog"),
    ] {
        let error = with(bad).unwrap_err().to_string();
        assert!(error.contains(of), "{bad}: {error}");
    }
}

#[test]
#[cfg(feature = "vol")]
fn smoke_in_a_file_of_its_own_stands_where_its_node_does() {
    use crate::{PhaseFunction, Translucent};

    // Two cubes of a metre, dense on the right.
    let mut vol = b"VOL\x03".to_vec();
    for word in [1_u32, 2, 1, 1, 1] {
        vol.extend(word.to_le_bytes());
    }
    for number in [0.0_f32, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 8.0] {
        vol.extend(number.to_le_bytes());
    }
    let (draft, mesh) = tetrahedron();
    let read_among = |nodes: &str, smoke: &str, bytes: &[u8]| {
        let node =
            format!(r#"{{"translation":[10,0,0],"scale":[2,2,2],"extras":{{"smoke":{smoke}}}}}"#);
        let document = draft.glb(&format!(r#"{mesh},"nodes":[{nodes}{node}]"#));
        gltf_from_slice(&document, &mut |path| {
            assert_eq!(path, "plume.vol");
            Ok(bytes.to_vec())
        })
    };
    let read = |smoke: &str, bytes: &[u8]| read_among(r#"{"mesh":0},"#, smoke, bytes);
    let smoke = r#"{"uri":"plume.vol","albedo":[0.9,0.8,0.7],"phase":"henyey-greenstein","g":0.5}"#;
    let loaded = read(smoke, &vol).unwrap();
    let [Translucent::Grid(grid)] = &loaded.scene.translucent[..] else {
        panic!("{:?}", loaded.scene.translucent);
    };
    assert_eq!(grid.albedo(), Vec3::new(0.9, 0.8, 0.7));
    assert_eq!(grid.phase(), PhaseFunction::HenyeyGreenstein { g: 0.5 });
    let near = |found: Vec3, expected: Vec3| (found - expected).abs().max_element() < 1e-4;
    assert!(near(grid.bounds().min(), Vec3::new(10.0, 0.0, 0.0)));
    assert!(near(grid.bounds().max(), Vec3::new(12.0, 2.0, 2.0)));
    let media = crate::Media::of(&loaded.scene);
    let at = |x: f64| media.extinction_at(glam::DVec3::new(x, 1.0, 1.0)).x;
    // Per metre of the world, whatever the size.
    assert!((at(11.0) - 4.0).abs() < 1e-6 && (at(11.5) - 6.0).abs() < 1e-6);
    // Nothing else needs to be there.
    let alone = read_among("", smoke, &vol).unwrap().scene;
    assert!(alone.instances.is_empty() && alone.translucent == loaded.scene.translucent);
    // Of colours in files of their own; the densities serve as both.
    let smoke = r#"{"uri":"plume.vol","emission":{"uri":"plume.vol","scale":[2,1,0.5]}}"#;
    let loaded = read(smoke, &vol).unwrap();
    let [Translucent::Grid(grid)] = &loaded.scene.translucent[..] else {
        panic!("{:?}", loaded.scene.translucent);
    };
    assert_eq!(grid.emission(), [Vec3::ZERO, Vec3::new(16.0, 8.0, 4.0)]);
    let thin = [&vol[..vol.len() - 8], &[0; 4], &0.5_f32.to_le_bytes()].concat();
    let smoke = r#"{"uri":"plume.vol","albedo":{"uri":"plume.vol"}}"#;
    let loaded = read(smoke, &thin).unwrap();
    let [Translucent::Grid(grid)] = &loaded.scene.translucent[..] else {
        panic!("{:?}", loaded.scene.translucent);
    };
    assert_eq!(grid.albedo_samples(), [Vec3::ZERO, Vec3::splat(0.5)]);
    for (smoke, bytes, of) in [
        (r#"{"uri":"plume.vol","albedo":2}"#, &vol[..], "albedo"),
        (
            r#"{"uri":"plume.vol","albedo":{"uri":"plume.vol"}}"#,
            &vol,
            "albedo",
        ),
        (r#"{"uri":"plume.vol","albedo":{"scale":1}}"#, &vol, "scale"),
        (r#"{"uri":"plume.vol","albedo":{"uri":1}}"#, &vol, "albedo"),
        (
            r#"{"uri":"plume.vol","emission":3}"#,
            &vol,
            "smoke.emission",
        ),
        (
            r#"{"uri":"plume.vol","emission":{"scale":3}}"#,
            &vol,
            "smoke that emits",
        ),
        (
            r#"{"uri":"plume.vol","emission":{"uri":"plume.vol","scale":-3}}"#,
            &vol,
            "smoke.emission.scale",
        ),
        (
            r#"{"uri":"plume.vol","emission":{}}"#,
            &vol,
            "a uri, a scale or both",
        ),
        (r#"{"uri":"plume.vol","albedo":{}}"#, &vol, "smoke.albedo"),
        (r#"{"uri":"plume.vol","sigma_s":2}"#, &vol, "smoke"),
        (r#"{"uri":"plume.vol"}"#, &vol[..40], "bytes"),
        (
            r#"{"uri":"plume.vol"}"#,
            b"PNG",
            "neither VOL, NanoVDB nor OpenVDB",
        ),
        (r#"{"uri":7}"#, &vol, "smoke.uri"),
        (r#""plume.vol""#, &vol, "smoke"),
    ] {
        let error = read(smoke, bytes).unwrap_err().to_string();
        assert!(error.contains(of), "{smoke}: {error}");
    }
}

#[test]
fn the_extras_of_the_scene_go_before_those_of_the_document_and_the_asset() {
    let (draft, mesh) = tetrahedron();
    let extras = |sigma: f32| format!(r#""extras":{{"medium":{{"sigma_s":{sigma}}}}}"#);
    for (scene, document, asset, expected) in [
        (1.0, 2.0, 3.0, 1.0),
        (0.0, 2.0, 3.0, 2.0),
        (0.0, 0.0, 3.0, 3.0),
    ] {
        let put = |sigma: f32| {
            if sigma > 0.0 {
                extras(sigma)
            } else {
                r#""extras":{}"#.into()
            }
        };
        let json = draft.json(
            Some("x.bin"),
            &format!(
                r#"{mesh},"nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0],{}}}],{}"#,
                put(scene),
                put(document)
            ),
        );
        let version = r#""version":"2.0""#;
        let json = json.replace(version, &format!("{version},{}", put(asset)));
        let loaded = gltf_from_slice(json.as_bytes(), &mut |_| Ok(draft.binary.clone())).unwrap();
        assert_eq!(loaded.scene.medium.unwrap().sigma_s().x, expected);
    }
}

#[test]
fn a_bad_medium_is_refused_by_field() {
    for (medium, field) in [
        ("3", "\"medium\""),
        ("{}", "sigma_s or sigma_a"),
        (r#"{"sigma_t":1}"#, "sigma_t"),
        (r#"{"sigma_s":-1}"#, "medium.sigma_s"),
        (r#"{"sigma_s":"1"}"#, "medium.sigma_s"),
        (r#"{"sigma_s":[1,2]}"#, "medium.sigma_s"),
        (r#"{"sigma_a":[1,2,-3]}"#, "medium.sigma_a"),
        (r#"{"sigma_a":1e99}"#, "medium.sigma_a"),
        (r#"{"sigma_s":3e38}"#, "sigma_s"),
        (r#"{"sigma_s":1,"phase":"mie"}"#, "medium.phase"),
        (r#"{"sigma_s":1,"phase":null}"#, "medium.phase"),
        (r#"{"sigma_s":1,"phase":"henyey-greenstein"}"#, "medium.g"),
        (
            r#"{"sigma_s":1,"phase":"henyey-greenstein","g":1}"#,
            "medium.g",
        ),
        (r#"{"sigma_s":1,"g":0.5}"#, "medium.g"),
        (r#"{"sigma_s":1,"phase":"schlick","g":0.5}"#, "medium.g"),
        (r#"{"sigma_s":1,"phase":"schlick","k":2}"#, "medium.k"),
        (r#"{"sigma_s":1,"phase":"droplets"}"#, "medium.diameter"),
        (
            r#"{"sigma_s":1,"phase":"droplets","diameter":4}"#,
            "medium.diameter",
        ),
        (
            r#"{"sigma_s":1,"phase":"double-henyey-greenstein","g":0.5,"weight":0.5}"#,
            "medium.g",
        ),
        (
            r#"{"sigma_s":1,"phase":"double-henyey-greenstein","g":[0.5,1],"weight":0.5}"#,
            "medium.g",
        ),
        (
            r#"{"sigma_s":1,"phase":"double-henyey-greenstein","g":[0.5,0]}"#,
            "medium.weight",
        ),
        (r#"{"sigma_s":1,"weight":0.5}"#, "medium.weight"),
        (r#"{"sigma_s":1,"box":[0,1]}"#, "medium.box"),
        (r#"{"sigma_s":1,"box":[[0,0,0],[1,0,1]]}"#, "medium.box"),
        (
            r#"{"sigma_s":1,"box":[[0,0,0],[1,1,1],[2,2,2]]}"#,
            "medium.box",
        ),
    ] {
        let error = with_extras(medium).unwrap_err().to_string();
        assert!(error.contains(field), "{medium}: {error}");
    }
}
