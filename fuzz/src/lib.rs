//! Shared parts of the fuzz targets: small valid recordings, reading a file, and checkpoints with correct checksums.

use kinetoscope_physics::prepare;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{ChannelDeclaration, GasSpeeds, GasTemperature};
use kinetoscope_recording::checkpoint::{self, Content};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::frame::{Frame, Level, StateColumn};
use kinetoscope_recording::reader::{RecordedFrame, Recording};
use kinetoscope_recording::recorder::{
    Clock, Compression, Header, Outcome, Recorder, RecorderState, Selection,
};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery};
use std::num::{NonZeroU32, NonZeroU64, NonZeroUsize};
use std::path::{Path, PathBuf};

const COLUMNS: &[StateColumn] =
    &[StateColumn { name: "x", unit: "m" }, StateColumn { name: "y", unit: "m" }];
const CHANNELS: &[ChannelDeclaration] =
    &[ChannelDeclaration::of::<GasTemperature>(), ChannelDeclaration::of::<GasSpeeds>()];

/// Recordings of three frames, one per compression.
pub fn recordings() -> Vec<Vec<u8>> {
    [Compression::None, Compression::Lz4, Compression::Zstd].map(recording).into()
}

fn header(compression: Compression) -> Header {
    Header {
        manifest: "name = \"sample\"\n".to_owned(),
        run_key: "00c0ffee".repeat(8),
        model: "gas",
        physics_version: 1,
        program_version: "0.1.0".to_owned(),
        time_unit: "s",
        state_columns: COLUMNS,
        channels: CHANNELS,
        selection: Selection::Named(vec![
            "state".to_owned(),
            "temperature".to_owned(),
            "speeds".to_owned(),
        ]),
        scenery: Scenery {
            walls: Vec::new(),
            view: [[0.0, 0.0], [1.0, 1.0]],
            drawn_radius: DrawnRadius::Fixed(0.1),
            speed_range_top: 1.0,
            speed_unit: "m/s",
            arrows: false,
            force_range_top: None,
            trail: false,
            unused_fields: Vec::new(),
            names: Vec::new(),
            central_particle: None,
        },
        playback_fps: 25.0,
        max_drawn_particles: NonZeroU32::new(10_000).unwrap(),
        draw_every: NonZeroU64::MIN,
        compression,
        stored: kinetoscope_recording::recorder::StoredFrames::All,
        frames_expected: Some(3),
        model_time: Some(1.0),
    }
}

fn recording(compression: Compression) -> Vec<u8> {
    let header = header(compression);
    let mut recorder = Recorder::create(Vec::new(), &header).unwrap();
    for count in 0..3 {
        let mut frame = Frame::new();
        let value = (1.0 + count as f64) / 3.0;
        frame.push_state(&[value, -value]);
        frame.push_state(&[1.0 / value, 0.0]);
        frame.push(&GasTemperature {
            mean_square_temperature_k: value,
            ..GasTemperature::default()
        });
        frame.push(&GasSpeeds { density: vec![value; 3], ..GasSpeeds::default() });
        frame.log(Level::Warning, "a line");
        recorder.write(Clock { count, time: value }, &mut frame).unwrap();
    }
    recorder.finish(&Outcome::Complete).unwrap()
}

/// The identity stored in the checkpoints.
pub const IDENTITY: &str = "fuzz";

/// The bytes of a checkpoint before its content, for a content of the given length.
fn envelope(content_bytes: usize) -> Vec<u8> {
    let empty = checkpoint::encode(IDENTITY, &[]).unwrap();
    // An empty content is preceded by its length and followed only by its checksum.
    let mut envelope = empty[..empty.len() - 12].to_vec();
    envelope.extend((content_bytes as u64).to_le_bytes());
    envelope
}

/// A checkpoint with any content and the matching checksum.
pub fn checkpoint_of(content: &[u8]) -> Vec<u8> {
    let mut bytes = envelope(content.len());
    bytes.extend(content);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// The content of the checkpoint of a run that has just started, for each model, preceded by the number of the model.
pub fn starts() -> Vec<Vec<u8>> {
    (0..4)
        .zip(["dem", "gas", "packing", "orbit"])
        .map(|(number, model)| start(number, model))
        .collect()
}

fn start(number: u8, model: &str) -> Vec<u8> {
    let starter = Path::new("../src/manifest/model").join(model).join("starter.toml");
    let text = std::fs::read_to_string(starter).unwrap();
    let experiment = kinetoscope_manifest::parse(&text, "starter.toml", &[]).unwrap();
    let config = &experiment.runs[0].manifest.model;
    let model = prepare(config, Seed { seed: 1, replicate: 0 }, false).unwrap();
    let parts: [&dyn Content; 2] = [&(1_u64, recorder_state()), &*model];
    let bytes = checkpoint::encode(IDENTITY, &parts).unwrap();
    let content = checkpoint::content(&bytes, IDENTITY).unwrap();
    [&[number], content].concat()
}

/// The state of a recorder that has written its header.
fn recorder_state() -> RecorderState {
    let folder = scratch_file().with_extension("folder");
    std::fs::create_dir_all(&folder).unwrap();
    let file = RecordingFile::create(&folder, "start").unwrap();
    let recorder = Recorder::create_resumable(file, &header(Compression::Zstd)).unwrap();
    let state = recorder.save_point().unwrap();
    drop(recorder);
    std::fs::remove_dir_all(&folder).unwrap();
    state
}

/// A file of this process, in memory if the system offers a folder for that.
pub fn scratch_file() -> PathBuf {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    folder.join(format!("kinetoscope-fuzz-{}.mcap", std::process::id()))
}

/// All frames, with decoded messages, that a reader with the given number of threads delivers from a file, and the error that
/// follows, if any. Panics if a frame follows an error.
pub fn read(path: &Path, threads: usize) -> (Vec<RecordedFrame>, Option<String>) {
    let threads = NonZeroUsize::new(threads).unwrap();
    let mut whole = Vec::new();
    let frames = match Recording::open(path).and_then(|recording| recording.frames_on(threads)) {
        Ok(frames) => frames,
        Err(error) => return (whole, Some(error.to_string())),
    };
    let mut error = None;
    for frame in frames {
        assert_eq!(error, None, "a frame or an error follows an error");
        match frame.and_then(look_into) {
            Ok(frame) => whole.push(frame),
            Err(fault) => error = Some(fault.to_string()),
        }
    }
    (whole, error)
}

/// Decodes the messages that the analysis would decode. A message that cannot be decoded is not an error of the frame.
fn look_into(frame: RecordedFrame) -> Result<RecordedFrame, ReadError> {
    if let Some(state) = frame.state() {
        (0..state.rows()).for_each(|row| assert_eq!(state.row(row).len(), state.columns().len()));
    }
    for answer in [frame.get::<GasTemperature>().map(|_| ()), frame.get::<GasSpeeds>().map(|_| ())]
    {
        drop(answer.map_err(|error| error.to_string()));
    }
    Ok(frame)
}
