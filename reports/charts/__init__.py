"""Figures as values, and their SVG: on pages (light, dark, live, on a phone) and as files that
stand alone.

A figure is a `Plate` of `Panel`s, and a panel is two axes and marks in the units of what it shows.
What they look like stands once, in templates/charts.css. Nothing here depends on a metric or an
engine.

Offered to the rest of reports:

    plate.py       `Plate` `Panel` `Cell` `Key` `Axis` `Frame` `Scale` `axis_limits` `tick_labels`;
                   `Arrow` `Band` `Bitmap` `Block` `Curve` `Dot` `Group` `Mark` `Note` `Rule`
                   `Segments`; `STATE_KEYS` `colour_scale` `figure_with_texts` `write_tables`
    templating.py  `STATE_NAMES` `Table` `colours_of` `in_template` `markdown_table` `script`
                   `table_text` `template` `words_of`
"""
