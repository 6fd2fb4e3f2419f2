# The comments are plain text: what stands in angle brackets or behind # in them is neither HTML nor a link.
:angle
s/(\/\/\/.*)<([A-Za-z\/])/\1\&lt;\2/
t angle
:hash
s/(\/\/\/.*[^\\])#/\1\\#/
t hash
# In documents: a header by its name alone becomes a link to its page; the method stays outside for its formulas.
s/\[([a-z]+\/[a-z_]+\.h)\]\(\.\.\/src\/core\/[^)]*\)/\1/g
s/\[([^]]*)\]\((docs\/)?method\.md(#[^)]*)?\)/\1/g
