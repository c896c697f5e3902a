!> What to do instead of the words of FEAP that this program does not have. doc/manual/feap.md lists
!! them for users.
!!
!! Source: the manual of FEAPpv, and that of FEAP for words that decks use often; SPRIng is in
!!         neither, but is often tried.
module deck_feap
  use base_text, only: key_of
  implicit none
  private
  public :: mesh_hint, command_hint, property_hint

contains

  !> What to do instead of a word of FEAP of the mesh part; empty if the word is none of these.
  pure function mesh_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    select case (key_of(word))
    case ('angl', 'cang', 'ceul', 'eang', 'eule', 'tria')
      hint = 'nodes have no axes of their own; rotate the body so that its supports lie along ' &
             //'the axes (TRANsform, or ROTAte of PATCh)'
    case ('base', 'cbas', 'ebas')
      hint = 'MOVE prescribes the motion of supports'
    case ('blen', 'side', 'snod')
      hint = 'curved bodies are read by PATCh with FILE, by NPATch, or by MESH'
    case ('body')
      hint = 'BODY FORCe is a record of MATErial'
    case ('btem', 'temp')
      hint = 'there are no temperatures'
    case ('cdam', 'damp')
      hint = 'there are no dampers; TRANsient,HHT and TRANsient,BACK dissipate energy'
    case ('cmas', 'mpro')
      hint = 'there are no masses at nodes; DENSity of MATErial gives mass'
    case ('coun')
      hint = 'sizes are counted; leave it out'
    case ('cpro')
      hint = 'EPROportional and FPROportional choose the load table of a node'
    case ('csti', 'spri', 'stif')
      hint = 'there are no springs; elements with a small modulus act as one'
    case ('debu')
      hint = 'every deck is checked; leave it out'
    case ('elin', 'link', 'slav')
      hint = 'TIE joins nodes at one place, CONStraint of MESH ties a node to others'
    case ('ereg', 'regi')
      hint = 'there are no regions; give each body its own PATCh, or its own material'
    case ('flex')
      hint = 'every body is flexible but a PATCh of TYPE RIGId'
    case ('foll')
      hint = 'PRESsure with FOLLower follows the surface'
    case ('glob')
      hint = 'ndm and ndf stand in the control record, the type of strains in MATErial'
    case ('join')
      hint = 'TIE joins nodes at one place; there are no other joints'
    case ('lfor')
      hint = 'FORCe, EFORce and CFORce load nodes, PRESsure loads faces'
    case ('load')
      hint = 'FORCe, EFORce and CFORce load nodes, PRESsure loads faces; PROP gives their course'
    case ('manu')
      hint = 'it concerns input by hand; leave it out'
    case ('mass')
      hint = 'there are no masses at nodes; DENSity of MATErial gives mass; MASS is a command, ' &
             //'between BATCh and END'
    case ('moda')
      hint = 'there are no modes; a body is elastic, or a PATCh of TYPE RIGId'
    case ('nblo', 'nsid')
      hint = 'NPATch takes the control points of a whole solid'
    case ('nopa', 'pars')
      hint = 'expressions are always evaluated; leave it out'
    case ('orde')
      hint = 'equations are ordered by METIS: leave it out'
    case ('peri')
      hint = 'CONStraint of MESH ties a node to others; there are no other periodic conditions'
    case ('pola')
      hint = 'COORdinates take expressions, such as r*cosd(30); TRANsform rotates and shifts nodes'
    case ('reac')
      hint = 'FORCe loads nodes; REAC is a command, between BATCh and END'
    case ('read')
      hint = 'INCLude reads another file'
    case ('rese')
      hint = 'restraints cannot be taken back; give each of them only where it is meant'
    case ('rigi')
      hint = 'a rigid body is a PATCh of TYPE RIGId'
    case ('rota')
      hint = 'ROTAte is a record of PATCh, MESH and SPLIne; TRANsform rotates nodes'
    case ('save')
      hint = 'it concerns records of the mesh; INCLude reads a file; SAVE is a command, ' &
             //'between BATCh and END'
    case ('sblo')
      hint = 'BLOCk makes 8-node elements in a mapped region'
    case ('shif')
      hint = 'TRANslate of PATCh and MESH shifts a body, TRANsform shifts nodes'
    case ('sloa')
      hint = 'PRESsure loads faces of bodies, CSURface a surface that is given by points'
    case ('sphe')
      hint = 'COORdinates take expressions, such as r*cosd(30); HEMIsphere of PATCh is half of ' &
             //'a hollow sphere'
    case ('spin')
      hint = 'there are no centrifugal forces; BODY FORCe of MATErial is constant; MOVE with ' &
             //'ROTAte turns a body'
    case ('swee')
      hint = 'MOVE with ROTAte prescribes a rotation'
    case ('titl')
      hint = 'the title stands behind FEAP in the first record; leave it out'
    case default
      hint = ''
    end select
    if (hint /= '') hint = 'not available here: '//hint
  end function mesh_hint

  !> What to do instead of a word of FEAP of the solution part; empty if the word is none of these.
  pure function command_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    select case (key_of(word))
    case ('acce')
      hint = 'accelerations are not printed; DISP prints displacements'
    case ('acti', 'deac')
      hint = 'parts of a body cannot be added or removed'
    case ('back')
      hint = 'AUTO takes a failed step back and repeats it in smaller ones'
    case ('base')
      hint = 'MOVE prescribes the motion of supports'
    case ('beta')
      hint = 'TRANsient chooses the scheme of time integration'
    case ('bfgs')
      hint = 'UTAN,LINE,1 searches along the increment; FACTor REUSe solves with an earlier tangent'
    case ('chec')
      hint = 'every deck is checked before it is solved; bezel --check does nothing else'
    case ('comm')
      hint = '! starts a comment'
    case ('cont')
      hint = 'contact is searched in each iteration; leave it out'
    case ('damp')
      hint = 'there is no damping matrix; TRANsient,HHT and TRANsient,BACK dissipate energy'
    case ('data')
      hint = 'give DT and TOL their values where they stand; INCLude reads another file'
    case ('debu', 'echo', 'show')
      hint = 'the log says what was read and done; leave it out'
    case ('dire', 'iter', 'meth')
      hint = 'FACTor chooses how linear systems are solved'
    case ('eige', 'eigv', 'subs')
      hint = 'there are no eigenvalues; the report counts the negative pivots of the tangent'
    case ('else', 'endi', 'if  ')
      hint = 'there are no conditions; a loop of Newton''s iteration ends when it has converged'
    case ('erro')
      hint = 'errors are not estimated; compare two meshes'
    case ('expl')
      hint = 'TRANsient is implicit; BACK, NEWMark or HHT'
    case ('geom')
      hint = 'TANG has the geometric stiffness of FINIte strains; leave it out'
    case ('hist', 'manu')
      hint = 'it concerns input by hand; leave it out'
    case ('iden')
      hint = 'there are no eigenvalues; leave it out'
    case ('init')
      hint = 'bodies start from rest and without displacements'
    case ('jint')
      hint = 'there are no J integrals; bonds of CONTact tear with an energy of their own'
    case ('line')
      hint = 'the law of MATErial decides; ELAStic ISOTropic is linear'
    case ('list')
      hint = 'CURVe names the quantities of a table'
    case ('mesh')
      hint = 'the mesh cannot change during the solution; PROP, MOVE and DISPlacement change ' &
             //'loads and motions'
    case ('moda')
      hint = 'there are no modes; TRANsient integrates in time'
    case ('newf')
      hint = 'give loads that stay a load table of their own; PROP, FPROportional and EPROportional'
    case ('nonl')
      hint = 'the law of MATErial decides; ELAStic NEOHook is nonlinear'
    case ('ntan')
      hint = 'TANG and UTAN form the tangent of all elements'
    case ('outm')
      hint = 'the result file has the mesh; the log says what was read'
    case ('paus')
      hint = 'a run never waits for input; leave it out'
    case ('quit')
      hint = 'END closes the commands, STOP the deck'
    case ('read')
      hint = 'RESTart continues from a checkpoint; INCLude reads another file'
    case ('renu')
      hint = 'equations are ordered by METIS: leave it out'
    case ('resi')
      hint = 'FORM forms the residual'
    case ('scre')
      hint = 'bezel --quiet shows less on the screen'
    case ('tie ')
      hint = 'TIE stands before BATCh'
    case ('velo')
      hint = 'velocities are not printed; DISP prints displacements'
    case ('writ')
      hint = 'PLOT and OUTPut write fields, SAVE a checkpoint'
    case ('zero')
      hint = 'give another analysis a deck of its own'
    case default
      hint = ''
    end select
    if (hint /= '') hint = 'not available here: '//hint
  end function command_hint

  !> What to do instead of a record that FEAP has in MATErial; empty if the word is none of these.
  pure function property_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    select case (key_of(word))
    case ('angl')
      hint = 'materials are isotropic and have no axes'
    case ('axis', 'plan')
      hint = 'models are three-dimensional (ndm = 3)'
    case ('cree', 'plas', 'visc')
      hint = 'ELAStic ISOTropic and ELAStic NEOHook are the laws'
    case ('damp')
      hint = 'there is no damping; TRANsient,HHT and TRANsient,BACK dissipate energy'
    case ('four', 'ther')
      hint = 'there are no temperatures'
    case ('geom')
      hint = 'FINIte strains contain the geometric stiffness; leave it out'
    case ('mass')
      hint = 'MASS is a command, between BATCh and END; DENSity gives mass'
    case ('mixe')
      hint = 'ENHAnced elements do not lock'
    case ('nonl')
      hint = 'FINIte, with ELAStic NEOHook, is for large deformations'
    case ('pres')
      hint = 'PRESsure is a word of the mesh, outside of MATErial'
    case ('quad')
      hint = 'QUADrature is a record of PATCh'
    case default
      hint = ''
    end select
    if (hint /= '') hint = 'not available here: '//hint
  end function property_hint

end module deck_feap
