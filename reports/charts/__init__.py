"""Small drawings as SVG text: axes, curves, maps. They take the page's colours, so they follow dark mode, print and phones."""
