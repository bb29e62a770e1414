//! Materials of DEM's discs, and the constants of pairs of them.

use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{NonNegative, Positive, Share};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, joined, quoted, refuse, table_schema};
use serde_json::{Value as Json, json};

/// What some of the discs are made of. Constants that are left out are those of `[model.dem]`.
#[derive(Clone, Debug, PartialEq)]
pub struct DemMaterial {
    /// Its name, for `contact_pairs`; neither `wall` nor empty.
    pub name: String,
    /// Its share of the discs, over the sum of all shares: each disc's material is drawn.
    pub share: Positive,
    /// Its areal density over that of a disc of the mean radius with the manifest's mass.
    pub density_ratio: Positive,
    /// Constants of contacts between two discs of it.
    pub constants: DemContactConstants,
}

/// Constants of the contacts between two materials, or of one with the walls.
#[derive(Clone, Debug, PartialEq)]
pub struct DemContactPair {
    /// Names of the two: of materials, or `wall`.
    pub between: [String; 2],
    /// The constants.
    pub constants: DemContactConstants,
}

/// Constants of a contact, as far as they are given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DemContactConstants {
    /// Coefficient of restitution e.
    pub restitution: Option<Share>,
    /// Coefficient of friction mu.
    pub friction: Option<NonNegative>,
    /// Coefficient of rolling friction mu_r.
    pub rolling_friction: Option<NonNegative>,
}

/// What `between` calls the walls.
pub const WALL: &str = "wall";
/// What `between` calls the discs where no materials are named.
pub const DISC: &str = "disc";
/// Materials of a run at most.
pub(super) const MOST_MATERIALS: usize = 8;

impl DemContactConstants {
    fn read(reader: &mut Reader<'_>) -> Self {
        Self {
            restitution: reader.optional("restitution", "", "", None),
            friction: reader.optional("friction", "", "", None),
            rolling_friction: reader.optional("rolling_friction", "", "", None),
        }
    }

    /// The keys that have a value, each behind a comma.
    fn write(&self) -> String {
        let key = |name: &str, text: Option<String>| {
            text.map_or_else(String::new, |text| format!(", {name} = {text}"))
        };
        key("restitution", self.restitution.map(|value| value.write()))
            + &key("friction", self.friction.map(|value| value.write()))
            + &key("rolling_friction", self.rolling_friction.map(|value| value.write()))
    }

    fn schema(own: &Json, required: &[&str]) -> Json {
        let constants = json!({
            "restitution": Share::schema(),
            "friction": NonNegative::schema(),
            "rolling_friction": NonNegative::schema()
        });
        table_schema(&joined(constants, own), required)
    }
}

impl TomlValue for DemMaterial {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            refuse(node, name, "a table { name, share, density_ratio, restitution, … }", errors);
            return None;
        };
        let mut reader = Reader::new(name, table, errors);
        let own: Option<String> = reader.required("name", node.span);
        let one = || Some(Positive::literal(1.0));
        let share = reader.optional("share", "", "", None).or_else(one);
        let density_ratio = reader.optional("density_ratio", "", "", None).or_else(one);
        let constants = DemContactConstants::read(&mut reader);
        if own.as_deref().is_some_and(|own| own.is_empty() || own == WALL) {
            reader.refuse(
                &["name"],
                "a material cannot have this name",
                "must be a name of its own; \"wall\" stands for the walls",
            );
        }
        let sound = reader.is_sound();
        reader.finish();
        let ((name, share), density_ratio) = own.zip(share).zip(density_ratio)?;
        let is_named = !name.is_empty() && name != WALL;
        (sound && is_named).then_some(Self { name, share, density_ratio, constants })
    }

    fn write(&self) -> String {
        format!(
            "{{ name = {}, share = {}, density_ratio = {}{} }}",
            quoted(&self.name),
            self.share.write(),
            self.density_ratio.write(),
            self.constants.write()
        )
    }

    fn schema() -> Json {
        let own = json!({
            "name": String::schema(),
            "share": Positive::schema(),
            "density_ratio": Positive::schema()
        });
        DemContactConstants::schema(&own, &["name"])
    }
}

impl TomlValue for DemContactPair {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            refuse(node, name, "a table { between = [\"…\", \"…\"], restitution, … }", errors);
            return None;
        };
        let mut reader = Reader::new(name, table, errors);
        let between: Option<[String; 2]> = reader.required("between", node.span);
        let constants = DemContactConstants::read(&mut reader);
        let sound = reader.is_sound();
        reader.finish();
        between.filter(|_| sound).map(|between| Self { between, constants })
    }

    fn write(&self) -> String {
        format!("{{ between = {}{} }}", self.between.write(), self.constants.write())
    }

    fn schema() -> Json {
        let own = json!({ "between": <[String; 2]>::schema() });
        DemContactConstants::schema(&own, &["between"])
    }
}
