//! The processor over its local bus, accessed by scripts.

use crate::{draw, jaw_spec, volume_of};
use strahl_sim::spec::{Classification, Leaping, Projection, Spec};
use strahl_sim::{Frame, VolumeStore, host_script, jaw};

/// The words that a read numbered `number` gave.
fn words(output: &str, number: u32) -> Vec<u32> {
    let beginning = format!("{number} 0x");
    let line = output
        .lines()
        .find(|line| line.starts_with(&beginning))
        .unwrap();
    let (_, words) = line.split_once(": ").unwrap();
    words.split(' ').map(|word| word.parse().unwrap()).collect()
}

/// Every tile of a picture, drawn over the bus by a script of its own, is that part of the picture: all words that a host
/// loads are in the script.
#[test]
fn tiles_over_the_bus_are_those_of_the_picture() {
    let volume = VolumeStore::new(&jaw([16, 16, 16]).unwrap()).unwrap();
    for (turn, is_perspective, leaping) in [
        (0.0, false, Leaping::Safe),
        (33.0, false, Leaping::Off),
        (-110.0, true, Leaping::Safe),
    ] {
        let mut spec = jaw_spec();
        spec.view.rotate_z_deg = turn;
        spec.view.rotate_x_deg = 0.5 * turn;
        spec.optimisation.leaping = leaping;
        spec.look.background = 0.2;
        if is_perspective {
            spec.view.projection = Projection::Perspective { angle_deg: 53.0 };
        }
        let frame = Frame::new(&spec, &volume).unwrap();
        let whole = draw(&spec, &volume);
        let [width, height] = whole.size.map(|n| n as usize);
        let tiles = frame.setup.tiles.map(|n| n as usize);
        let mut brightest = 0;
        for tile in 0..frame.setup.tile_count() {
            let script = host_script::of_tile(&frame, &volume, tile).unwrap();
            let output = host_script::run("tile.txt", &script, &spec).unwrap();
            let (results, ended) = (words(&output, 1), words(&output, 2));
            for (ray, result) in results.iter().enumerate() {
                let x = tile % tiles[0] * 8 + ray % 8;
                let y = tile / tiles[0] * 8 + ray / 8;
                if x < width && y < height {
                    let pixel = (height - 1 - y) * width + x;
                    let expected = (whole.picture[pixel] * 255.0).round() as u32;
                    assert_eq!(*result, expected, "tile {tile}, ray {ray}");
                    let has_ended = ended[ray / 32] >> (ray % 32) & 1 == 1;
                    assert_eq!(has_ended, whole.ended_early[pixel]);
                    brightest = brightest.max(*result);
                }
            }
        }
        assert!(brightest > 80, "{brightest}");
    }
}

#[test]
fn accesses_take_bus_clocks_and_tiles_take_their_own() {
    // A volume of zeros, one ray of 20 samples along y, no leaping.
    let mut spec = Spec::default();
    spec.optimisation.leaping = Leaping::Off;
    let ray = "DDW_ACC 0x10000 0 0 0 0 4096 0 20 0";
    let load = format!("LB_CLK 10\nDDW_ACC 0x4 8 32 8 # dims\n{ray}\n");
    // Bursts: 4 clocks for the first word, 1 for each other: 6 + 11.
    let script = format!(
        "{load}SRD_ACC 1 1\nSWR_ACC 0 1\nSRD_ACC 1 2\nWAITING 1000\nSRD_ACC 1 3\nSRD_ACC 7 4\n"
    );
    let output = host_script::run("test", &script, &spec).unwrap();
    let status = [1, 2, 3].map(|number| words(&output, number)[0]);
    assert_eq!(status, [0, 1, 0], "{output}");
    assert!(output.starts_with("1 0x1 210 ns: 0\n"), "{output}");
    // 20 samples of one ray, one every 7 clocks, and the way out.
    let clocks = words(&output, 4)[0];
    assert!((133..190).contains(&clocks), "{clocks}");
    // Results are held back until the tile is done; the next tile's parameters are not.
    let script =
        format!("{load}SWR_ACC 0 1\n{ray}\nSRD_ACC 1 1\nDDR_ACC 0x20000 64 2\nSRD_ACC 1 3\n");
    let output = host_script::run("test", &script, &spec).unwrap();
    assert_eq!((words(&output, 1)[0], words(&output, 3)[0]), (1, 0));
    assert_eq!(words(&output, 2), [0; 64]);
    // A second tile finds the rows open that the first has opened.
    let twice = format!("{load}SWR_ACC 0 1\nSRD_ACC 7 1\n{ray}\nSWR_ACC 0 1\nSRD_ACC 7 2\n");
    let output = host_script::run("test", &twice, &spec).unwrap();
    assert!(words(&output, 2)[0] < words(&output, 1)[0], "{output}");
    let slow = host_script::run("test", &twice.replace("LB_CLK 10", "LB_CLK 20"), &spec).unwrap();
    assert_eq!(words(&slow, 2), words(&output, 2));
}

#[test]
fn wrong_accesses_are_refused_with_their_line() {
    let spec = Spec::default();
    let started = "DDW_ACC 4 8 8 8\nSWR_ACC 0 1";
    for (script, problems) in [
        ("LB_CLK 10\nSWR_ACX 1 2", ["line 2", "DDR_ACC"]),
        ("SWR_ACC 1 2", ["nothing can be written", "0x1"]),
        ("SRD_ACC 0x10000 1", ["nothing can be read", "0x10000"]),
        ("SWR_ACC 0x100000 256", ["0x100", "8 bits"]),
        ("SWR_ACC 0 1", ["[0, 0, 0] voxels", "at least 2"]),
        (
            "DDW_ACC 4 2000 2000 2000\nSWR_ACC 0 1",
            ["line 2", "at most 16777216"],
        ),
        ("SWR_ACC 0 7", ["0x7", "1 starts"]),
        ("SWR_ACC 4 12x", ["12x", "32 bits"]),
        ("LB_CLK 0", ["LB_CLK 0", "above 0"]),
        ("DDR_ACC 0x20000 0 1", ["0 words", "1 to 65536"]),
        ("DDR_ACC 0x20000 65 1", ["nothing can be read", "0x20040"]),
        (
            "DDR_ACC 0xffffffff 2 1",
            ["nothing can be read", "0xffffffff"],
        ),
    ] {
        let message = host_script::run("bad.txt", script, &spec)
            .unwrap_err()
            .to_string();
        for problem in problems {
            assert!(message.contains(problem), "{script}: {message}");
        }
    }
    let ray = "DDW_ACC 0x10000 0 0 0 0 70000 0 20 0\n";
    let message = host_script::run("bad.txt", &format!("{ray}{started}"), &spec)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("line 3") && message.contains("15 bits"),
        "{message}"
    );
    let mut post = Spec::default();
    post.look.classification = Classification::Post;
    assert!(host_script::run("bad.txt", "", &post).is_err());
    let large = volume_of([128, 128, 65], vec![0; 128 * 128 * 65]);
    let frame = Frame::new(&spec, &large).unwrap();
    let message = host_script::of_tile(&frame, &large, 0)
        .unwrap_err()
        .to_string();
    assert!(message.contains("1048576"), "{message}");
}
