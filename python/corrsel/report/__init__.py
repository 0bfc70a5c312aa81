"""The report of a benchmark run, one module per section; `page.build` puts them together."""
