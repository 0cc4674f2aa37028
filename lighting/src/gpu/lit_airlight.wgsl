// The airlight of all lit parts of a path.
//
// Needs what fills the slots of the visibility and of the airlight.

// `joined`: whether parts that touch and are equally visible are evaluated as one.
fn light_lit_airlight(path: light_Path, joined: bool) -> vec3<f32> {
    var cursor = light_cursor(path);
    // The last interval that was found and has not been evaluated yet.
    var part = light_dark();
    var sum = vec3(0.0);
    loop {
        let next = light_next_lit(&cursor, path);
        let is_last = light_is_dark(next);
        let is_same = all(next.visibility == part.visibility);
        if joined && !is_last && is_same && next.start == part.end {
            part.end = next.end;
            continue;
        }
        if !light_is_dark(part) {
            sum += part.visibility * light_airlight(path, part.start, part.end);
        }
        if is_last {
            break;
        }
        part = next;
    }
    return sum;
}
