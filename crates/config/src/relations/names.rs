//! The names of cylinders and transducers: each is one thing's, and of something that is there.

use super::requirement::Relations;
use crate::settings::Settings;

impl Relations<'_> {
    pub(super) fn names(&mut self, settings: &Settings) {
        let mut known: Vec<(String, String)> = Vec::new();
        for (index, cylinder) in settings.cylinder.iter().enumerate() {
            let c2 = format!("cylinder[{index}].c2_name");
            self.require(
                cylinder.c2_name.is_none() || settings.signals.cylinder.c2.is_some(),
                &[&c2],
                format!("`{c2}` is there, but [signals.cylinder] names no `c2`"),
                "leave it out, or name the position by C2 as signals.cylinder.c2",
            );
            let named = [
                ("name", &cylinder.name),
                ("c1_name", &cylinder.c1_name),
                ("c2_name", &cylinder.c2_name),
            ];
            for (key, name) in
                named.into_iter().filter_map(|(key, name)| Some((key, name.as_ref()?)))
            {
                let key = format!("cylinder[{index}].{key}");
                // Who reads it on a radio does not hear capitals.
                let spoken = name.to_lowercase();
                let twin = known.iter().find(|(other, _)| *other == spoken).map(|(_, key)| key);
                self.require(
                    twin.is_none(),
                    &[&key],
                    format!(
                        "`{key}` is {name:?}, and so is `{}`",
                        twin.map_or("", String::as_str)
                    ),
                    "each cylinder and each transducer needs a name of its own, not only in capitals",
                );
                known.push((spoken, key));
            }
        }
    }
}
