//! Writes the seeds of all targets below `corpus/` in the current folder.

use std::fs;
use std::path::Path;

fn main() {
    let put = |target: &str, name: &str, bytes: &[u8]| {
        let folder = Path::new("corpus").join(target);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join(name), bytes).unwrap();
    };
    for (index, bytes) in (0_u8..).zip(kinetoscope_fuzz::recordings()) {
        put("reader", &format!("recording_{index}"), &bytes);
        put("reader", &format!("killed_{index}"), &bytes[..bytes.len() / 2]);
        put("damage", &format!("byte_100_{index}"), &[index, 100, 0, 1]);
    }
    for (index, bytes) in kinetoscope_fuzz::starts().iter().enumerate() {
        put("checkpoint", &format!("start_{index}"), bytes);
    }
    // 33 bytes that make a reader without checks panic: magic, an empty header record, a record of u64::MAX bytes.
    let header = [&[0x01][..], &7_u64.to_le_bytes(), &[0; 7]].concat();
    let hostile = [&b"\x89MCAP0\r\n"[..], &header, &[0x06], &u64::MAX.to_le_bytes()].concat();
    put("reader", "hostile_length", &hostile);
    for model in ["dem", "gas", "packing", "orbit"] {
        let starter = fs::read(Path::new("../src/manifest/model").join(model).join("starter.toml"));
        put("manifest", &format!("starter_{model}"), &starter.unwrap());
    }
    for experiment in fs::read_dir("../experiments").unwrap() {
        let path = experiment.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            put(
                "manifest",
                &path.file_name().unwrap().to_string_lossy(),
                &fs::read(&path).unwrap(),
            );
        }
    }
}
