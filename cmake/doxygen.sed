# The comments are plain text: what stands in angle brackets or behind # in them is neither HTML nor a link.
:angle
s/(\/\/\/.*)<([A-Za-z\/])/\1\&lt;\2/
t angle
:hash
s/(\/\/\/.*[^\\])#/\1\\#/
t hash
