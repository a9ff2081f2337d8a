//! Scripts of a host (document §9.2): accesses over the local bus as text, and what they read as text.
//!
//! ```text
//! LB_CLK 30                   period of the bus clock in ns
//! SWR_ACC 0x4 16              single write: address, value
//! DDW_ACC 0x10000 1 2 3       demand-DMA write: address, values
//! WAITING 100                 bus clocks
//! SRD_ACC 0x1 7               single read: address, a number that names it in the output
//! DDR_ACC 0x20000 64 8        demand-DMA read: address, words, number
//! ```
//!
//! Numbers are decimal, hexadecimal with 0x, or negative; `#` begins a comment. The output has a line per read: its number,
//! address, time in ns, and the words. Addresses: [`local_bus`](crate::local_bus).
//!
//! ```
//! use strahl_sim::{Spec, host_script};
//!
//! let output = host_script::run("test", "SWR_ACC 0x3 17\nSRD_ACC 0x3 1", &Spec::default())?;
//! assert!(output.starts_with("1 0x3 "), "{output}");
//! assert!(output.lines().next().is_some_and(|line| line.ends_with(": 17")));
//! # Ok::<(), strahl_sim::Error>(())
//! ```

use crate::Error;
use crate::frame::Frame;
use crate::local_bus::{
    CONTROL, ENDED, LocalBus, PARAMETERS, RESULTS, frame_writes, parameter_words,
};
use crate::spec::Spec;
use crate::stages::classify::Tables;
use crate::volume_store::VolumeStore;
use std::fmt::Write;

/// Voxels that a script may carry: as text they take some five bytes each.
const MOST_VOXELS: usize = 1 << 20;

/// Runs a script; what its reads and the bus have to say.
///
/// # Errors
/// A line that is no access, or an access that fails: file, line, and what would be right. A Spec that is not behind the bus.
pub fn run(file: &str, script: &str, spec: &Spec) -> Result<String, Error> {
    let mut bus = LocalBus::new(spec)?;
    let mut output = String::new();
    for (number, line) in script.lines().enumerate() {
        let text = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = text.split_whitespace().collect();
        access(&mut bus, &words, &mut output).map_err(|problem| Error::File {
            file: format!("{file}, line {}", number + 1),
            problem,
        })?;
    }
    let _ = writeln!(
        output,
        "# {:.0} ns, {} bus clocks, {} tiles, {} pipeline clocks",
        bus.time_ns(),
        bus.bus_clocks,
        bus.counters.tiles,
        bus.counters.clocks
    );
    Ok(output)
}

fn access(bus: &mut LocalBus, words: &[&str], output: &mut String) -> Result<(), String> {
    let Some((name, arguments)) = words.split_first() else {
        return Ok(());
    };
    let numbers = arguments
        .iter()
        .map(|text| number(text))
        .collect::<Result<Vec<u32>, String>>();
    match (*name, arguments.len()) {
        ("LB_CLK", 1) => {
            let period: f64 = arguments[0].parse().unwrap_or(0.0);
            if !(period > 0.0 && period <= 1e6) {
                return Err(format!(
                    "LB_CLK {}: a period in ns, above 0, up to 1000000",
                    arguments[0]
                ));
            }
            bus.set_clock_ns(period);
        }
        ("WAITING", 1) => bus.wait(u64::from(numbers?[0])),
        ("SWR_ACC", 2) => {
            let numbers = numbers?;
            bus.write(numbers[0], &numbers[1..])?;
        }
        ("DDW_ACC", 2..) => {
            let numbers = numbers?;
            bus.write(numbers[0], &numbers[1..])?;
        }
        ("SRD_ACC", 2) => {
            let numbers = numbers?;
            read(bus, numbers[0], 1, numbers[1], output)?;
        }
        ("DDR_ACC", 3) => {
            let numbers = numbers?;
            if !(1..=1 << 16).contains(&numbers[1]) {
                return Err(format!(
                    "DDR_ACC reads {} words; it must be 1 to 65536",
                    numbers[1]
                ));
            }
            read(bus, numbers[0], numbers[1], numbers[2], output)?;
        }
        _ => {
            return Err(format!(
                "{} is no access; there are LB_CLK period, WAITING clocks, SWR_ACC address value, SRD_ACC address number, \
                 DDW_ACC address values, DDR_ACC address words number",
                words.iter().take(4).copied().collect::<Vec<_>>().join(" ")
            ));
        }
    }
    Ok(())
}

fn read(
    bus: &mut LocalBus,
    address: u32,
    count: u32,
    number: u32,
    output: &mut String,
) -> Result<(), String> {
    let words = bus.read(address, count)?;
    let words: Vec<String> = words.iter().map(u32::to_string).collect();
    let _ = writeln!(
        output,
        "{number} {address:#x} {:.0} ns: {}",
        bus.time_ns(),
        words.join(" ")
    );
    Ok(())
}

fn number(text: &str) -> Result<u32, String> {
    let parsed = match (text.strip_prefix("0x"), text.starts_with('-')) {
        (Some(digits), _) => u32::from_str_radix(digits, 16).ok(),
        (None, true) => text.parse::<i32>().ok().map(|value| value as u32),
        (None, false) => text.parse().ok(),
    };
    parsed.ok_or_else(|| format!("{text} is no number of 32 bits"))
}

/// The script of a host that draws one tile of a frame: everything that it loads, the parameters, the start, the results
/// (number 1) and the rays that ended early (number 2).
///
/// # Errors
/// A tile that the frame does not have, or a volume too large for a text.
pub fn of_tile(frame: &Frame, volume: &VolumeStore, tile: usize) -> Result<String, Error> {
    if tile >= frame.setup.tile_count() {
        let problem = format!("the picture has {} tiles", frame.setup.tile_count());
        return Err(Error::field("tile", tile, problem));
    }
    if volume.words.len() > MOST_VOXELS {
        let problem = format!("a script carries at most {MOST_VOXELS}");
        return Err(Error::field("voxels", volume.words.len(), problem));
    }
    let look = frame.spec.look.settled(volume.range);
    let tables = Tables::new(
        &look,
        frame.spec.widths.data,
        |word| volume.value(word),
        volume.range,
    );
    let pre_table: Vec<u16> = (0..=u16::MAX).map(|voxel| tables.bus_word(voxel)).collect();
    let mut text = String::from("LB_CLK 30\n");
    for (address, words) in frame_writes(frame, &volume.words, &pre_table) {
        write_words(&mut text, address, &words);
    }
    write_words(&mut text, PARAMETERS, &parameter_words(frame, tile));
    let rays = frame.spec.queue.bundle[0] * frame.spec.queue.bundle[1];
    let _ = writeln!(text, "SWR_ACC {CONTROL:#x} 1");
    let _ = writeln!(text, "DDR_ACC {RESULTS:#x} {rays} 1");
    let _ = writeln!(text, "DDR_ACC {ENDED:#x} {} 2", rays.div_ceil(32));
    Ok(text)
}

/// Bursts of at most 64 words; runs of zeros are what memories begin with.
fn write_words(text: &mut String, address: u32, words: &[u32]) {
    for (i, burst) in words.chunks(64).enumerate() {
        if burst.iter().all(|word| *word == 0) && words.len() > 64 {
            continue;
        }
        let _ = write!(text, "DDW_ACC {:#x}", address + 64 * i as u32);
        for word in burst {
            match *word as i32 {
                negative @ ..0 => {
                    let _ = write!(text, " {negative}");
                }
                _ => {
                    let _ = write!(text, " {word}");
                }
            }
        }
        text.push('\n');
    }
}
