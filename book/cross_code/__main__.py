import sys,json,pathlib
o=pathlib.Path(sys.argv[sys.argv.index("--output")+1]); (o/"index.md").write_text("# x\n"); (o/"pages.json").write_text("[]")
