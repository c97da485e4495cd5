"""Products of results files.

file            reading of a results file
pictures        curves, maps, sections
sweep_page      page of a sweep
compare         scores of curves
judgement       expected ranges
report          one HTML page
charts          charts of pictures and pages, as data
maps            maps of fields of pictures and pages, as data
words           names in words, and units that suit values
solids          bodies of the page, on their meshes
packing         numbers of the page, as text
fields_export   recorded fields as CSV, VTU
"""
